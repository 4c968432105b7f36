#include "stylet/study/tradeoff.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/units.hpp"
#include "stylet/output/progress.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/scene/loader.hpp"
#include "stylet/scene/requirement.hpp"
#include "stylet/study/converge.hpp"
#include "stylet/study/levels.hpp"
#include "stylet/study/richardson.hpp"
#include "stylet/study/study_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* quantity = "seeds.0.placement_error";
constexpr double patience = 10;  // times the usual way's steps at equal mesh and step

/// Each differs from the usual way in one thing.
std::vector<Way> ways(bool has_shortcut, bool in_space) {
  const std::string implicit = "time.method=implicit";
  const std::string shortcut = has_shortcut ? "time.until=implanted" : "time.until=settled";
  const std::string euler = "time.scheme=backward_euler";
  const std::string explicit_steps = "time.method=explicit";
  std::vector<Way> ways{
      {usual_way, {implicit, euler, shortcut}, true},
      {"generalised_alpha", {implicit, "time.scheme=generalised_alpha", shortcut}},
      {"average_acceleration", {implicit, "time.scheme=average_acceleration", shortcut}},
      {slow_limit_way, {"time.method=quasi_static", shortcut}},
      {"lagged_cutting", {implicit, euler, shortcut, "needles.0.cutting.law=lagged"}},
      {"quasi_static_lagged",
       {"time.method=quasi_static", shortcut, "needles.0.cutting.law=lagged"}},
      {"lumped_mass", {implicit, euler, shortcut, "tissue.mass=lumped"}},
      {"p1", {implicit, euler, shortcut, "tissue.formulation=p1"}, true},
      {"p1_averaged", {implicit, euler, shortcut, "tissue.formulation=p1_averaged"}, true},
      {"whole_procedure", {implicit, euler, "time.until=settled"}},
      {"explicit", {explicit_steps, shortcut}},
      // Explicit steps cannot bear stiffness damping; this one settles tissue within centiseconds.
      {"explicit_mass_damped",
       {explicit_steps, shortcut, "tissue.damping.stiffness_factor=null",
        "tissue.damping.mass_factor=200 1/s"}},
  };
  if (in_space) {
    ways.push_back({"p2", {implicit, euler, shortcut, "tissue.formulation=p2"}, true});
  }
  return ways;
}

std::string level_changes(int refine) {
  return "mesh.refine=" + std::to_string(refine);
}

class Study {
 public:
  Study(MPI_Comm comm,
        const std::string& scene_file,
        const std::string& text,
        const std::vector<std::string>& changes,
        const TradeoffOptions& options)
      : comm_(comm), file_(scene_file), text_(text), changes_(changes), options_(options) {
    const Scene scene = load_scene(file_, text_, changes_);
    if (scene.start) {
      refuse_key(scene, "start", "tradeoff changes methods; allowed: scenes that begin at rest");
    }
    if (scene.procedure) {
      refuse_key(scene, "procedure",
                 "tradeoff changes laws of needles; allowed: a scene with needles");
    }
    bool has_seed = false;
    for (const auto& needle : scene.needles) {
      for (const auto& action : needle.motion) has_seed |= !action.target.empty();
    }
    if (!has_seed) {
      throw InputError(file_ +
                       ": key 'targets': no seed with a target, so no placement error to "
                       "trade");
    }
    if (options.mesh_levels < 1 || options.step_levels < 1 || options.repeats < 1) {
      throw InputError("tradeoff: --mesh-levels, --step-levels and --repeats: allowed: 1 or more");
    }
    require_levels(comm, "tradeoff", scene, scene.mesh.refine + double(options.mesh_levels),
                   scene.time.step / 2, scene.time.step * std::pow(2.0, options.step_levels - 1));
    meshes_ = mesh_files(comm, std::span(&scene, 1));
    n_cells_ = "n_" + scene.cells();
    has_kernel_ = scene.dim() == 3;
    for (const auto& needle : scene.needles) radii_.push_back(needle.space.kernel_radius);
    plan_all(scene);
  }

  Tradeoff run() {
    result_.folder = study_folder(options_.study, "tradeoff", file_);
    OpenStudy study = open_study(comm_, result_.folder, "tradeoff", {"tradeoff.json"},
                                 options_.study, plan_json(), columns());
    in_folder(*study.folder, [&] {
      run_in(std::move(study.kept));
      Json summary{{"status", "completed"}, {"runs", result_.runs.size()}};
      add_identity(summary, meshes_);
      study.folder->finish(summary);
    });
    return result_;
  }

 private:
  void plan_all(const Scene& scene) {
    const bool has_shortcut = allows("time.until=implanted");
    Scene settled = scene;
    settled.time.until_implanted = false;
    if (!has_shortcut) require_places(settled);
    const auto all = ways(has_shortcut, has_kernel_);
    const std::vector<double> own = {1};
    const std::vector<double> kernels = has_kernel_ ? std::vector{1, 1 / kernel_ratio} : own;
    for (const Way& way : all) {
      if (way.name == "whole_procedure" && (!has_shortcut || hides_places(settled))) continue;
      for (const double kernel : way.is_element ? kernels : own) {
        for (int mesh = 0; mesh < options_.mesh_levels; ++mesh) {
          for (int step = 0; step < options_.step_levels; ++step) {
            // Explicit steps are cut to the stable one.
            if (way.name.starts_with("explicit") && step > 0) continue;
            plan(way, {scene.mesh.refine + mesh, scene.time.step * std::pow(2.0, step), kernel});
          }
        }
      }
    }
    for (const double kernel : kernels) {
      plan({reference_way, all.front().changes},
           {scene.mesh.refine + options_.mesh_levels, scene.time.step / 2, kernel});
      (void)load_scene(file_, text_,
                       overrides_.back());  // without it there is nothing to compare with
    }
  }

  void run_in(Table kept) {
    // Rows are in the order of the runs; behind a missing one they are run again.
    std::size_t n_rows = 0;
    while (n_rows < kept.rows.size() && kept.rows[n_rows].front() == id_of(n_rows)) ++n_rows;
    kept.rows.resize(n_rows);
    for (std::size_t i = 0; i < n_rows; ++i) {
      const auto steps = plain_number(kept.rows[i][kept.column("steps")]);
      if (steps) remember_steps(i, *steps);
    }
    ResultsFile results(comm_, result_.folder + "/results.csv", std::move(kept));
    Progress progress(comm_, options_.study.quiet);
    for (std::size_t i = n_rows; i < result_.runs.size(); ++i) {
      const auto row = measure(i, [&](double own) {
        if (!progress.due()) return;
        progress.update((static_cast<double>(i) + own) / static_cast<double>(result_.runs.size()),
                        result_.runs[i].way + ", run " + std::to_string(i + 1) + " of " +
                            std::to_string(result_.runs.size()));
      });
      if (rank_of(comm_) == 0) results.append({row});
    }
    results.finish();
    read_back();
    check_unused_options();
    report(comm_, result_, options_.study.quiet);
    if (options_.study.picture) draw(comm_, "tradeoff.py", result_.folder, options_.study.quiet);
  }

  [[nodiscard]] bool allows(const std::string& change) const {
    auto changes = changes_;
    changes.push_back(change);
    try {
      (void)load_scene(file_, text_, changes);
      return true;
    } catch (const InputError&) {
      return false;
    }
  }

  void plan(const Way& way, const Level& level) {
    TradeoffRun& run = result_.runs.emplace_back();
    run.way = way.name;
    run.refine = level.refine;
    run.step = level.step;
    run.kernel = level.kernel;
    auto& changes = overrides_.emplace_back(changes_);
    changes.insert(changes.end(), way.changes.begin(), way.changes.end());
    changes.push_back(level_changes(level.refine));
    changes.push_back("time.step=" + exact(level.step) + " s");
    for (std::size_t i = 0; i < radii_.size() && level.kernel != 1; ++i) {
      changes.push_back(item("needles", i) + ".kernel_radius=" + exact(level.kernel * radii_[i]) +
                        " m");
    }
    changes.emplace_back("output.snapshots=null");
  }

  [[nodiscard]] Json plan_json() const {
    Json plan{{"study", "tradeoff"},
              {"repeats", options_.repeats},
              {"changes", overrides_},
              {"scene", text_}};
    add_identity(plan, meshes_);
    return plan;
  }

  static std::string id_of(std::size_t i) {
    char text[24];
    std::snprintf(text, sizeof text, "%05zu", i);
    return text;
  }

  [[nodiscard]] std::vector<std::string> columns() const {
    std::vector<std::string> names{"run", "way", "status", "refine", "step [s]"};
    if (has_kernel_) names.emplace_back("kernel");
    names.insert(names.end(), {n_cells_, "steps", "placement_error", "error", "wall_time [s]",
                               "shortest [s]", "longest [s]"});
    return names;
  }

  std::vector<std::string> row(std::size_t i,
                               const StudyRun& run,
                               std::vector<double> times) const {
    std::ranges::sort(times);
    const auto number = [&](const std::string& path) {
      const auto value = find_number(run.summary, path);
      return value ? exact(*value) : "";
    };
    const TradeoffRun& planned = result_.runs[i];
    std::vector<std::string> row{id_of(i), planned.way, run.error.empty() ? "done" : "failed",
                                 std::to_string(planned.refine), exact(planned.step)};
    if (has_kernel_) row.push_back(exact(planned.kernel));
    row.insert(row.end(),
               {number(n_cells_), number("sub_steps"), number(quantity), run.error,
                exact(times[times.size() / 2]), exact(times.front()), exact(times.back())});
    return row;
  }

  std::vector<std::string> measure(std::size_t i, const Poll& poll) {
    constexpr double long_run = 10;  // s
    StudyRun run;
    std::vector<double> times;
    try {
      const Scene scene = load_scene(file_, text_, overrides_[i]);
      keep_scene(comm_, result_.folder, id_of(i), scene);
      double total = 0;
      const RunPlace place{checkpoint_path(result_.folder, id_of(i)), options_.study.quiet};
      while (static_cast<int>(times.size()) < options_.repeats && total < long_run) {
        run = run_in_study(comm_, scene, meshes_, place, poll, [&](const Simulation& simulation) {
          stop_if_hopeless(i, simulation.counts().sub_steps);
        });
        if (run.stopped) stop_study(comm_);
        if (rank_of(comm_) == 0) forget_checkpoint(result_.folder, id_of(i));  // of this repeat
        // All ranks decide by the same clock.
        MPI_Bcast(&run.seconds, 1, MPI_DOUBLE, 0, comm_);
        times.push_back(run.seconds);
        total += run.seconds;
        if (!run.error.empty()) break;
      }
    } catch (const InputError& error) {
      run.error = one_line(error.what());
    }
    if (times.empty()) times.push_back(0);
    if (const auto steps = find_number(run.summary, "sub_steps")) remember_steps(i, *steps);
    return row(i, run, times);
  }

  void remember_steps(std::size_t i, double steps) {
    const TradeoffRun& run = result_.runs[i];
    if (run.way == usual_way) usual_steps_[{run.refine, run.step}] = steps;
  }

  /// Throws NumericalError: undamped tissue may never settle. Counted in steps, so that it does not
  /// depend on the machine.
  void stop_if_hopeless(std::size_t i, long long steps) const {
    const TradeoffRun& run = result_.runs[i];
    const auto known = usual_steps_.find({run.refine, run.step});
    if (run.way.starts_with("explicit") || known == usual_steps_.end()) return;
    if (static_cast<double>(steps) <= patience * known->second) return;
    throw NumericalError("stopped after " + std::to_string(steps) + " steps, " +
                         std::to_string(static_cast<int>(patience)) + " times those of " +
                         usual_way);
  }

  void read_back() {
    const std::string path = result_.folder + "/results.csv";
    const Table table = read_csv(path, read_on_all(comm_, path));
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      const auto& row = table.rows[i];
      TradeoffRun& run = result_.runs.at(i);
      if (row[2] != "done") {
        run.failure = row[table.column("error")];
        continue;
      }
      run.value = std::stod(row[table.column("placement_error")]);
      run.seconds = std::stod(row[table.column("wall_time [s]")]);
    }
    compare();
    for (TradeoffRun& run : result_.runs) {
      for (const TradeoffRun& finer : result_.runs) {
        if (finer.way == run.way && finer.failure.empty() && finer.refine >= run.refine &&
            finer.step <= run.step && finer.kernel == run.kernel) {
          run.safe_error = std::max(run.safe_error, finer.error);
        }
      }
    }
    for (TradeoffRun& run : result_.runs) {
      if (!run.failure.empty() || is_reference(run)) continue;
      run.on_front = std::ranges::none_of(result_.runs, [&](const TradeoffRun& other) {
        return other.failure.empty() && !is_reference(other) && other.seconds <= run.seconds &&
               other.safe_error <= run.safe_error &&
               (other.seconds < run.seconds || other.safe_error < run.safe_error);
      });
    }
  }

  /// With the finest run of each kernel, and that kernel with none: the two differ by the share of the kernel's
  /// own error that its smaller square takes away.
  void compare() {
    const auto first = std::ranges::find_if(result_.runs, is_reference);
    for (auto run = first; run != result_.runs.end(); ++run) {
      if (!run->failure.empty()) {
        throw NumericalError("tradeoff: the reference run failed: " + run->failure);
      }
    }
    result_.reference = first->value;
    if (has_kernel_) {
      const double without =
          extrapolate_known(first->value, result_.runs.back().value, kernel_ratio, kernel_order)
              .limit;
      result_.kernel_error = std::abs(first->value - without);
    }
    for (TradeoffRun& run : result_.runs) {
      const auto finest = std::find_if(
          first, result_.runs.end(),
          [&](const TradeoffRun& reference) { return reference.kernel == run.kernel; });
      run.error = std::abs(run.value - finest->value) +
                  result_.kernel_error * std::pow(run.kernel, kernel_order);
    }
  }

  MPI_Comm comm_;
  std::string file_;
  std::string text_;
  std::vector<std::string> changes_;
  const TradeoffOptions& options_;
  std::vector<std::vector<std::string>> overrides_;
  std::map<std::pair<int, double>, double> usual_steps_;  ///< by refine and step
  Tradeoff result_;
  MeshFiles meshes_;
  std::string n_cells_;        ///< a number of summary.json
  bool has_kernel_ = false;    ///< the scene is in space
  std::vector<double> radii_;  ///< m; of the needles' kernels
};

}  // namespace

Tradeoff tradeoff(MPI_Comm comm,
                  const std::string& scene_file,
                  const std::string& text,
                  const std::vector<std::string>& changes,
                  const TradeoffOptions& options) {
  return Study(comm, scene_file, text, changes, options).run();
}

}  // namespace stylet
