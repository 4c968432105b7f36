#include "stylet/study/plan.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/output/history.hpp"
#include "stylet/output/progress.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/owned.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/run.hpp"
#include "stylet/simulation/simulation.hpp"
#include "stylet/study/identity.hpp"

#include <petsctao.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <numeric>

namespace stylet {

namespace {

using OwnedTao = Owned<Tao, TaoDestroy>;
using Values = std::vector<double>;

constexpr double unit = 1e-3;            // m; variables and residuals are in millimetres
constexpr double first_radius = 2;       // of the trust region, mm
constexpr double jitter_shift = 0.5e-3;  // m; about half an element of the usual meshes

bool is_stop(const Action& action) {
  return action.kind == ActionKind::insert || action.kind == ActionKind::retract;
}

/// What may change of one needle, as shifts of the scene in millimetres; speed as a share of its range.
class Variables {
 public:
  Variables(const Scene& scene, std::size_t needle, const PlanOptions& options)
      : needle_(needle), options_(options) {
    const auto& motion = scene.needles[needle].motion;
    for (std::size_t i = 0; i < motion.size(); ++i) {
      if (motion[i].kind != ActionKind::implant || motion[i].target.empty()) continue;
      std::size_t stop = i;
      while (stop > 0 && !is_stop(motion[stop])) --stop;
      if (is_stop(motion[stop]) && std::ranges::find(stops_, stop) == stops_.end()) {
        stops_.push_back(stop);
      }
    }
    has_height_ = options.height_range > 0;
    if (options.speeds) {
      const auto [low, high] = *options.speeds;
      const auto insert = std::ranges::find(motion, ActionKind::insert, &Action::kind);
      start_speed_ = std::clamp((insert->speed - low) / (high - low), 0.0, 1.0);
    }
  }

  [[nodiscard]] std::size_t size() const {
    return stops_.size() + (has_height_ ? 1 : 0) + (options_.speeds ? 1 : 0);
  }
  [[nodiscard]] bool empty() const { return stops_.empty(); }

  [[nodiscard]] Values start() const {
    Values values(size(), 0.0);
    if (options_.speeds) values.back() = start_speed_ * speed_scale;
    return values;
  }
  [[nodiscard]] Values bounds(double sign) const {
    Values values(stops_.size(), sign * options_.depth_range / unit);
    if (has_height_) values.push_back(sign * options_.height_range / unit);
    if (options_.speeds) values.push_back(sign < 0 ? 0.0 : speed_scale);
    return values;
  }

  /// The variables that stand at an end of their range.
  [[nodiscard]] std::vector<std::string> at_ends(const Values& values) const {
    const Values low = bounds(-1);
    const Values high = bounds(1);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < values.size(); ++i) {
      constexpr double close = 1e-6;  // of the range
      const double room = std::min(values[i] - low[i], high[i] - values[i]);
      if (room > close * (high[i] - low[i])) continue;
      if (i < stops_.size()) {
        names.push_back("the stop of motion." + std::to_string(stops_[i]) + " (--depth-range)");
      } else if (has_height_ && i == stops_.size()) {
        names.emplace_back("the height (--height-range)");
      } else {
        names.emplace_back("the speed (--speed-range)");
      }
    }
    return names;
  }

  void apply(const Values& values, Scene& scene) const {
    auto& needle = scene.needles[needle_];
    for (std::size_t i = 0; i < stops_.size(); ++i) {
      Action& action = needle.motion[stops_[i]];
      if (action.position) *action.position += unit * values[i];
      if (action.depth) *action.depth -= unit * values[i];  // needles advance towards -x
    }
    if (has_height_) needle.height += unit * values[stops_.size()];
    if (!options_.speeds) return;
    const auto [low, high] = *options_.speeds;
    for (Action& action : needle.motion) {
      if (action.kind != ActionKind::insert) continue;
      const double old = action.speed;
      action.speed = low + values.back() / speed_scale * (high - low);
      if (&action == &needle.motion.front()) scene.time.step *= old / action.speed;
    }
  }

 private:
  static constexpr double speed_scale = 10;  // like millimetres for the trust region

  std::size_t needle_;
  const PlanOptions& options_;
  std::vector<std::size_t> stops_;
  bool has_height_ = false;
  double start_speed_ = 0;
};

class Planner {
 public:
  Planner(MPI_Comm comm, const Scene& scene, const PlanOptions& options, const std::string& folder)
      : comm_(comm),
        options_(options),
        scene_(scene),
        progress_(comm, options.quiet),
        file_(comm,
              folder + "/plan.csv",
              {{"run", ""}, {"needle", ""}, {"seed", ""}, {"placement_error", "m"}}) {
    // Where the tissue goes back to rest, only the placement is asked for, and a needle's seeds do not
    // depend on those after it; else the whole scene is run.
    shortcut_ = why_not_at_rest(scene).empty();
    scene_.time.until_implanted = shortcut_;
    scene_.output = {};
    scene_.output.history = false;
    scene_.expect.clear();
  }

  void run(Plan& plan) {
    for (std::size_t n = 0; n < scene_.needles.size(); ++n) {
      const Variables variables(scene_, n, options_);
      if (variables.empty()) continue;
      const Values before = residuals(variables, variables.start(), n);
      const Values best = minimise(variables, n, before.size());
      const auto spread = jitter(variables, best, n);
      const Values after = residuals(variables, best, n);
      const double wanted = options_.tolerance / unit * std::sqrt(0.5 * double(after.size()));
      if (std::sqrt(std::inner_product(after.begin(), after.end(), after.begin(), 0.0)) > wanted) {
        for (const auto& end : variables.at_ends(best)) {
          plan.at_ends.push_back(scene_.needles[n].name + ": " + end);
        }
      }
      variables.apply(best, scene_);
      std::size_t k = 0;
      for (const Action& action : scene_.needles[n].motion) {
        if (action.kind != ActionKind::implant || action.target.empty()) continue;
        PlannedSeed seed{scene_.needles[n].name,
                         action.target,
                         unit * std::hypot(before[2 * k], before[2 * k + 1]),
                         unit * std::hypot(after[2 * k], after[2 * k + 1]),
                         spread[k],
                         {}};
        if (options_.accuracy) {
          const auto quantity = "seeds." + std::to_string(plan.seeds.size()) + ".placement_error";
          seed.uncertainty = options_.accuracy->of(quantity, scene_.mesh.refine, scene_.time.step);
        }
        plan.seeds.push_back(std::move(seed));
        ++k;
      }
    }
    plan.runs = n_runs_;
    file_.close();
  }

  /// What was planned, put into the scene that was given.
  [[nodiscard]] Scene planned(const Scene& given) const {
    Scene scene = given;
    scene.needles = scene_.needles;
    scene.time.step = scene_.time.step;
    scene.expect.clear();  // of the scene as it was
    return scene;
  }

 private:
  /// Vectors from targets to seeds (mm), two numbers a seed of this needle.
  Values residuals(const Variables& variables, const Values& values, std::size_t needle) {
    if (const auto known = known_.find({needle, values}); known != known_.end()) {
      return known->second;
    }
    Scene scene = scene_;
    variables.apply(values, scene);
    if (shortcut_) scene.needles.resize(needle + 1);
    ++n_runs_;
    Values result;
    try {
      Simulation simulation(comm_, scene, false);
      while (!simulation.done()) simulation.step();
      std::vector<EmbeddedPoint> places;
      for (const Seed& seed : simulation.seeds()) places.push_back(simulation.place_of(seed));
      const auto world = simulation.body().world(places);
      for (std::size_t i = 0; i < places.size(); ++i) {
        const Seed& seed = simulation.seeds()[i];
        if (seed.needle != scene.needles[needle].name || seed.target.empty()) continue;
        const auto& targets = simulation.scene().targets;
        const auto target = std::ranges::find(targets, seed.target, &Target::name);
        const Vector2 at_rest{places[i].x.x - target->point.x, places[i].x.y - target->point.y};
        const Vector2 at_end{world[i].x - target->point.x, world[i].y - target->point.y};
        const Vector2 miss = shortcut_ ? at_rest : at_end;
        result.insert(result.end(), {miss.x / unit, miss.y / unit});
      }
    } catch (const Error& error) {
      throw Error(error.code(),
                  "plan: a run with changed stops failed; narrower --depth-range and "
                  "--height-range may help: " +
                      std::string(error.what()));
    }
    for (std::size_t k = 0; k < result.size() / 2; ++k) {
      const double row[] = {double(n_runs_), double(needle), double(k),
                            unit * std::hypot(result[2 * k], result[2 * k + 1])};
      file_.write(row);
    }
    file_.flush();
    if (progress_.due()) {
      progress_.update(0,
                       "needle " + std::to_string(needle + 1) + ", run " + std::to_string(n_runs_));
    }
    known_[{needle, values}] = result;
    return result;
  }

  static PetscErrorCode evaluate(Tao, Vec x, Vec f, void* context) {
    return guard([&] {
      const PetscScalar* values = nullptr;
      PetscInt n = 0;
      check(VecGetLocalSize(x, &n));
      check(VecGetArrayRead(x, &values));
      const Values point(values, values + n);
      check(VecRestoreArrayRead(x, &values));
      const Values miss = (*static_cast<std::function<Values(const Values&)>*>(context))(point);
      PetscScalar* out = nullptr;
      check(VecGetArray(f, &out));
      std::ranges::copy(miss, out);
      check(VecRestoreArray(f, &out));
    });
  }

  static OwnedVec vector_of(const Values& values) {
    OwnedVec vec;
    check(VecCreateSeq(PETSC_COMM_SELF, static_cast<PetscInt>(values.size()), vec.put()));
    PetscScalar* array = nullptr;
    check(VecGetArray(vec.get(), &array));
    std::ranges::copy(values, array);
    check(VecRestoreArray(vec.get(), &array));
    return vec;
  }

  // Every rank minimises the same numbers; only the runs are parallel.
  Values minimise(const Variables& variables, std::size_t needle, std::size_t n_residuals) {
    std::function<Values(const Values&)> function = [&](const Values& point) {
      return residuals(variables, point, needle);
    };
    // POUNDERS wants room for its first radius above where it starts.
    const Values least = variables.bounds(-1);
    const Values most = variables.bounds(1);
    double radius = first_radius;
    for (std::size_t i = 0; i < most.size(); ++i) {
      radius = std::min(radius, 0.5 * (most[i] - least[i]));
    }
    Values start = variables.start();
    for (std::size_t i = 0; i < most.size(); ++i) start[i] = std::min(start[i], most[i] - radius);
    const OwnedVec x = vector_of(start);
    const OwnedVec low = vector_of(least);
    const OwnedVec high = vector_of(most);
    const OwnedVec f = vector_of(Values(n_residuals));
    OwnedTao tao;
    check(TaoCreate(PETSC_COMM_SELF, tao.put()));
    check(TaoSetOptionsPrefix(tao.get(), "plan_"));
    check(TaoSetType(tao.get(), TAOPOUNDERS));
    check(TaoSetSolution(tao.get(), x.get()));
    check(TaoSetVariableBounds(tao.get(), low.get(), high.get()));
    check(TaoSetResidualRoutine(tao.get(), f.get(), evaluate, &function));
    check(TaoSetMaximumFunctionEvaluations(tao.get(), options_.most_runs));
    const double tolerance = options_.tolerance / unit;
    const double n_seeds = static_cast<double>(n_residuals) / 2;
    check(TaoSetFunctionLowerBound(tao.get(), n_seeds * tolerance * tolerance));
    check(PetscOptionsSetValue(nullptr, "-plan_tao_pounders_delta", exact(radius).c_str()));
    check(TaoSetFromOptions(tao.get()));
    check(TaoSolve(tao.get()));
    const PetscScalar* values = nullptr;
    check(VecGetArrayRead(x.get(), &values));
    Values best(values, values + variables.size());
    check(VecRestoreArrayRead(x.get(), &values));
    return best;
  }

  /// Standard deviation (m) of every seed's distance from where the plan puts it, over shifts of the
  /// plan by half an element, the shift itself taken off: what the mesh alone does to it.
  std::vector<double> jitter(const Variables& variables, const Values& best, std::size_t needle) {
    const Values middle = residuals(variables, best, needle);
    std::vector<double> squares(middle.size() / 2, 0.0);
    const std::size_t n_shifted = variables.size() - (options_.speeds ? 1 : 0);
    for (std::size_t v = 0; v < n_shifted; ++v) {
      Values up = best;
      Values down = best;
      up[v] += jitter_shift / unit;
      down[v] -= jitter_shift / unit;
      const Values above = residuals(variables, up, needle);
      const Values below = residuals(variables, down, needle);
      // A smooth dependence cancels to second order in the mean of both sides.
      for (std::size_t k = 0; k < squares.size(); ++k) {
        const double x = 0.5 * (above[2 * k] + below[2 * k]) - middle[2 * k];
        const double y = 0.5 * (above[2 * k + 1] + below[2 * k + 1]) - middle[2 * k + 1];
        squares[k] += (x * x + y * y) / 1.5 / static_cast<double>(n_shifted);
      }
    }
    for (double& value : squares) value = unit * std::sqrt(value);
    return squares;
  }

  MPI_Comm comm_;
  const PlanOptions& options_;
  Scene scene_;
  bool shortcut_ = false;  ///< runs end at the last implant
  Progress progress_;
  HistoryWriter file_;
  std::map<std::pair<std::size_t, Values>, Values> known_;  ///< by needle and variables
  int n_runs_ = 0;
};

void check_options(const Scene& scene, const PlanOptions& options) {
  bool has_target = false;
  for (const auto& needle : scene.needles) {
    for (const auto& action : needle.motion) has_target |= !action.target.empty();
  }
  if (!has_target) {
    throw InputError(scene.file + ": key 'targets': nothing to plan: no implant has a target");
  }
  // Loads may last, but what moves the tissue must have an end.
  Scene unloaded = scene;
  unloaded.body_forces.clear();
  unloaded.tractions.clear();
  unloaded.prescribed.clear();
  if (const std::string why = why_not_at_rest(unloaded); !why.empty()) {
    throw InputError(scene.file + ": key 'needles': a plan is for seeds at rest, but " + why);
  }
  if (options.depth_range <= 0 || options.height_range < 0 || options.tolerance <= 0 ||
      (options.speeds &&
       !(0 < (*options.speeds)[0] && (*options.speeds)[0] < (*options.speeds)[1]))) {
    throw InputError(
        "plan: allowed: --depth-range and --tolerance above 0, --height-range 0 or "
        "above, --speed-range of a lower and a higher speed");
  }
}

/// Collective. What `plan` does once its folder is there.
void plan_in(OutputFolder& folder,
             MPI_Comm comm,
             const Scene& scene,
             const PlanOptions& options,
             Plan& result) {
  Planner planner(comm, scene, options, result.folder);
  planner.run(result);
  check_unused_options();
  result.scene = planner.planned(scene);
  write_text_atomically(comm, result.folder + "/planned.yaml", resolved_text(result.scene));
  auto summary = summary_of(result);
  add_identity(summary, mesh_files(comm, std::span(&scene, 1)));
  folder.finish(summary);
}

}  // namespace

Plan plan(MPI_Comm comm, const Scene& scene, const PlanOptions& options) {
  check_options(scene, options);
  Plan result;
  result.folder = options.output;
  if (result.folder.empty()) {
    result.folder = "out/plan-" + std::filesystem::path(scene.file).stem().string();
  }
  OutputFolder folder(comm, result.folder, {"plan", {"plan.csv", "planned.yaml"}, {}},
                      options.force ? Earlier::replace : Earlier::refuse, OnSignal::end);
  in_folder(folder, [&] {
    folder.go_on();
    plan_in(folder, comm, scene, options, result);
  });
  if (rank_of(comm) == 0 && !options.quiet) print(result, scene);
  if (!result.at_ends.empty()) throw_at_ends(result);
  return result;
}

}  // namespace stylet
