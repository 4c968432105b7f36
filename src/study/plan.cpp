#include "stylet/study/plan.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/output/progress.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/owned.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/scene/writer.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/run.hpp"
#include "stylet/simulation/simulation.hpp"
#include "stylet/study/identity.hpp"
#include "stylet/study/plan_variables.hpp"
#include "stylet/study/study_run.hpp"
#include "stylet/study/table.hpp"

#include <petsctao.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>

namespace stylet {

namespace {

using OwnedTao = Owned<Tao, TaoDestroy>;
using Values = std::vector<double>;

constexpr double unit = PlanVariables::unit;  // of residuals too
constexpr double first_radius = 2;            // of the trust region, mm
constexpr double jitter_shift = 0.5e-3;       // m; about half an element of the usual meshes

class Planner {
 public:
  Planner(MPI_Comm comm,
          const Scene& scene,
          const PlanOptions& options,
          const std::string& folder,
          MeshFiles meshes,
          Table kept)
      : comm_(comm),
        options_(options),
        folder_(folder),
        meshes_(std::move(meshes)),
        scene_(scene),
        progress_(comm, options.study.quiet) {
    // Where the tissue goes back to rest, only the placement is asked for, and a needle's seeds do not
    // depend on those after it; else the whole scene is run.
    shortcut_ = why_not_at_rest(scene).empty();
    scene_.time.until_implanted = shortcut_;
    OutputParameters output;
    output.history = false;
    output.checkpoint = scene.output.checkpoint;
    scene_.output = output;
    scene_.expect.clear();
    for (const auto& row : kept.rows) remember(row);
    results_.emplace(comm, folder + "/results.csv", std::move(kept));
  }

  static std::vector<std::string> columns() {
    return {"run", "needle", "variables [mm]", "misses [mm]", "wall_time [s]"};
  }

  void run(Plan& plan) {
    for (std::size_t n = 0; n < scene_.needles.size(); ++n) {
      const PlanVariables variables(scene_, n, options_);
      if (variables.empty()) continue;
      const Values before = residuals(variables, variables.start(), n);
      const Values best = minimise(variables, n, before.size());
      const auto spread = jitter(variables, best, n);
      const Values after = residuals(variables, best, n);
      const double wanted =
          options_.tolerance / unit * std::sqrt(double(after.size()) / double(dim()));
      if (std::sqrt(std::inner_product(after.begin(), after.end(), after.begin(), 0.0)) > wanted) {
        for (const auto& end : variables.at_ends(best)) {
          plan.shortfalls.push_back(scene_.needles[n].name + ": " + end);
        }
        if (out_of_runs_) {
          plan.shortfalls.push_back(scene_.needles[n].name + ": its " +
                                    std::to_string(options_.most_runs) + " runs are used up");
        }
      }
      variables.apply(best, scene_);
      std::size_t k = 0;
      for (const Action& action : scene_.needles[n].motion) {
        if (action.kind != ActionKind::implant || action.target.empty()) continue;
        PlannedSeed seed{scene_.needles[n].name, action.target, distance_of(before, k),
                         distance_of(after, k),  spread[k],     {}};
        if (options_.accuracy) {
          const auto quantity = "seeds." + std::to_string(plan.seeds.size()) + ".placement_error";
          seed.uncertainty = options_.accuracy->of(quantity, scene_.mesh.refine, scene_.time.step);
        }
        plan.seeds.push_back(std::move(seed));
        ++k;
      }
    }
    plan.runs = n_runs_;
    results_->finish();
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
  /// Of the k-th seed (m).
  [[nodiscard]] double distance_of(const Values& misses, std::size_t k) const {
    const double x = misses[dim() * k];
    const double y = misses[dim() * k + 1];
    return unit * (dim() == 2 ? std::hypot(x, y) : std::hypot(std::hypot(x, y), misses[3 * k + 2]));
  }

  /// Numbers of a seed's miss.
  [[nodiscard]] std::size_t dim() const { return static_cast<std::size_t>(scene_.dim()); }

  /// Vectors from targets to seeds (mm), two or three numbers a seed of this needle.
  Values residuals(const PlanVariables& variables, const Values& values, std::size_t needle) {
    if (const auto known = known_.find({needle, values}); known != known_.end()) {
      return known->second;
    }
    Scene scene = scene_;
    variables.apply(values, scene);
    if (shortcut_) scene.needles.resize(needle + 1);
    const std::string id = id_of(++n_runs_);
    Values result;
    const RunPlace place{checkpoint_path(folder_, id), options_.study.quiet};
    const StudyRun run = run_in_study(
        comm_, scene, meshes_, place, [](double) {},
        [&](const Simulation& simulation) {
          if (simulation.done()) result = misses(simulation, scene.needles[needle].name);
        });
    if (run.stopped) stop_study(comm_);
    if (!run.error.empty()) {
      throw Error(run.code,
                  "plan: a run with changed stops failed; narrower --depth-range and "
                  "--height-range may help: " +
                      run.error);
    }
    if (rank_of(comm_) == 0) {
      results_->append(
          {{id, std::to_string(needle), text_of(values), text_of(result), exact(run.seconds)}});
      forget_checkpoint(folder_, id);
    }
    if (progress_.due()) {
      progress_.update(0,
                       "needle " + std::to_string(needle + 1) + ", run " + std::to_string(n_runs_));
    }
    known_[{needle, values}] = result;
    return result;
  }

  /// Vectors from targets to seeds of that needle (mm).
  [[nodiscard]] Values misses(const Simulation& simulation, const std::string& needle) const {
    Values result;
    std::vector<EmbeddedPoint> places;
    for (const Seed& seed : simulation.seeds()) places.push_back(simulation.place_of(seed));
    const auto world = simulation.body().world(places);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Seed& seed = simulation.seeds()[i];
      if (seed.needle != needle || seed.target.empty()) continue;
      const auto& targets = simulation.scene().targets;
      const auto target = std::ranges::find(targets, seed.target, &Target::name);
      const ReferencePlace there = target->point.place();
      const WorldPlace at_end{world[i].x - there.x, world[i].y - there.y, world[i].z - there.z};
      const Vector3 at_rest = places[i].x - there;
      const Vector3 miss = shortcut_ ? at_rest : Vector3{at_end.x, at_end.y, at_end.z};
      for (std::size_t k = 0; k < dim(); ++k) result.push_back(component(miss, k) / unit);
    }
    return result;
  }

  /// A row of an earlier start; the same way leads through it.
  void remember(const std::vector<std::string>& row) {
    known_[{std::stoul(row[1]), numbers_of(row[2])}] = numbers_of(row[3]);
    n_runs_ = std::max(n_runs_, std::stoi(row[0]));
  }

  static std::string id_of(int run) {
    char text[16];
    std::snprintf(text, sizeof text, "%05d", run);
    return text;
  }
  static std::string text_of(const Values& values) {
    std::vector<std::string> texts;
    for (const double value : values) texts.push_back(exact(value));
    return join(texts, " ");
  }
  static Values numbers_of(const std::string& text) {
    std::istringstream in(text);
    return Values(std::istream_iterator<double>(in), {});
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
  Values minimise(const PlanVariables& variables, std::size_t needle, std::size_t n_residuals) {
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
    const double n_seeds = static_cast<double>(n_residuals) / static_cast<double>(dim());
    check(TaoSetFunctionLowerBound(tao.get(), n_seeds * tolerance * tolerance));
    check(PetscOptionsSetValue(nullptr, "-plan_tao_pounders_delta", exact(radius).c_str()));
    check(TaoSetFromOptions(tao.get()));
    check(TaoSolve(tao.get()));
    TaoConvergedReason reason = TAO_CONTINUE_ITERATING;
    check(TaoGetConvergedReason(tao.get(), &reason));
    out_of_runs_ = reason == TAO_DIVERGED_MAXFCN;
    const PetscScalar* values = nullptr;
    check(VecGetArrayRead(x.get(), &values));
    Values best(values, values + variables.size());
    check(VecRestoreArrayRead(x.get(), &values));
    return best;
  }

  /// Standard deviation (m) of every seed's distance from where the plan puts it, over shifts of the
  /// plan by half an element, the shift itself taken off: what the mesh alone does to it.
  std::vector<double> jitter(const PlanVariables& variables,
                             const Values& best,
                             std::size_t needle) {
    const Values middle = residuals(variables, best, needle);
    std::vector<double> squares(middle.size() / dim(), 0.0);
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
        double square = 0;
        for (std::size_t i = dim() * k; i < dim() * (k + 1); ++i) {
          const double x = 0.5 * (above[i] + below[i]) - middle[i];
          square += x * x;
        }
        squares[k] += square / 1.5 / static_cast<double>(n_shifted);
      }
    }
    for (double& value : squares) value = unit * std::sqrt(value);
    return squares;
  }

  MPI_Comm comm_;
  const PlanOptions& options_;
  std::string folder_;
  MeshFiles meshes_;
  Scene scene_;
  bool shortcut_ = false;  ///< runs end at the last implant
  Progress progress_;
  std::optional<ResultsFile> results_;
  std::map<std::pair<std::size_t, Values>, Values> known_;  ///< by needle and variables
  int n_runs_ = 0;
  bool out_of_runs_ = false;  ///< of the present needle
};

void check_options(const Scene& scene, const PlanOptions& options) {
  if (scene.procedure) {
    refuse_key(scene, "procedure", "a plan moves needles; allowed: a scene with needles");
  }
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
      options.most_runs < 1 ||
      (options.speeds &&
       !(0 < (*options.speeds)[0] && (*options.speeds)[0] < (*options.speeds)[1]))) {
    throw InputError(
        "plan: allowed: --depth-range, --tolerance and --most-runs above 0, --height-range 0 or "
        "above, --speed-range of a lower and a higher speed");
  }
}

/// All that decides what is run, and in which order.
nlohmann::ordered_json plan_json(const Scene& scene,
                                 const PlanOptions& options,
                                 const MeshFiles& meshes) {
  nlohmann::ordered_json plan{{"study", "plan"},
                              {"depth_range", options.depth_range},
                              {"height_range", options.height_range},
                              {"tolerance", options.tolerance},
                              {"most_runs", options.most_runs}};
  if (options.speeds) plan["speeds"] = *options.speeds;
  Scene given = scene;
  given.output = {};
  plan["scene"] = to_yaml(given);
  add_identity(plan, meshes);
  return plan;
}

}  // namespace

Plan plan(MPI_Comm comm, const Scene& scene, const PlanOptions& options) {
  check_options(scene, options);
  Plan result;
  result.folder = study_folder(options.study, "plan", scene.file);
  const MeshFiles meshes = mesh_files(comm, std::span(&scene, 1));
  OpenStudy study = open_study(comm, result.folder, "plan", {"planned.yaml"}, options.study,
                               plan_json(scene, options, meshes), Planner::columns());
  in_folder(*study.folder, [&] {
    Planner planner(comm, scene, options, result.folder, meshes, std::move(study.kept));
    planner.run(result);
    check_unused_options();
    result.scene = planner.planned(scene);
    write_text_atomically(comm, result.folder + "/planned.yaml", resolved_text(result.scene));
    auto summary = summary_of(result);
    add_identity(summary, meshes);
    study.folder->finish(summary);
  });
  if (rank_of(comm) == 0 && !options.study.quiet) print(result, scene);
  if (!result.shortfalls.empty()) throw_shortfalls(result);
  return result;
}

}  // namespace stylet
