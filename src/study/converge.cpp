#include "stylet/study/converge.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/output/progress.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/scene/requirement.hpp"
#include "stylet/scene/writer.hpp"
#include "stylet/simulation/accuracy.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/study/field_sample.hpp"
#include "stylet/study/levels.hpp"
#include "stylet/study/pool.hpp"
#include "stylet/study/study_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

constexpr double ratio = 2;

// Of a displacement in L2. Quadratic cells reach three, but not around a needle, at supports' edges and jumps of
// stiffness; what is not believed makes the band wider.
constexpr double mesh_order = 2;
constexpr double step_order = 2;

/// What a scene gives that can converge.
std::vector<std::string> quantities_of(const Scene& scene) {
  std::vector<std::string> paths;
  std::size_t seed = 0;
  for (const auto& needle : scene.needles) {
    for (const auto& action : needle.motion) {
      if (action.kind != ActionKind::implant) continue;
      const std::string own = "seeds." + std::to_string(seed++);
      if (!action.target.empty() && !hides_places(scene)) {
        paths.push_back(own + ".placement_error");
      }
      paths.push_back(own + ".tip_displacement");
    }
  }
  if (scene.procedure) {
    for (const ProcedureRow& row : scene.procedure->rows) {
      if (row.kind != ProcedureRow::Kind::implant) continue;
      const std::string own = "seeds." + std::to_string(seed++);
      if (!row.target.empty()) paths.push_back(own + ".placement_error");
      paths.push_back(own + ".tip_displacement");
    }
  }
  if (!scene.needles.empty() || scene.procedure) paths.emplace_back("peak_needle_force");
  for (const auto& probe : scene.probes) {
    for (int k = 0; k < scene.dim(); ++k) {
      paths.push_back(below("probes", probe.name) + "." + std::to_string(k));
    }
  }
  if (paths.empty()) {
    throw InputError(scene.file + ": nothing to converge: the scene has no needle and no probes");
  }
  return paths;
}

class Study {
 public:
  Study(MPI_Comm comm, const Scene& scene, const ConvergeOptions& options)
      : comm_(comm), scene_(scene), options_(options) {
    if (options.mesh_levels < 1 || options.step_levels < 1 ||
        options.mesh_levels + options.step_levels < 3) {
      throw InputError(
          "converge: --mesh-levels and --step-levels: allowed: 1 or more, and 2 or "
          "more for one of them");
    }
    if (scene.time.method == TimeMethod::explicit_newmark && options.step_levels > 1) {
      throw InputError(scene.file +
                       ": key 'time.method': explicit steps are cut to the stable step, so there "
                       "are no step levels to study; use --step-levels 1");
    }
    if (scene.start) {
      refuse_key(scene, "start",
                 "bands would leave out the error of what lies before; allowed: scenes that begin "
                 "at rest");
    }
    if (scene.procedure && options.store) {
      refuse_key(scene, "procedure",
                 "--store keeps the accuracy of scenes with needles of their own");
    }
    result_.quantities = quantities_of(scene);
    require_levels(comm, "converge", scene, scene.mesh.refine + options.mesh_levels - 1.0,
                   scene.time.step / std::pow(ratio, options.step_levels - 1), scene.time.step);
    meshes_ = mesh_files(comm, std::span(&scene, 1));
    add_series("mesh", options.mesh_levels, 1);
    add_series("step", 1, options.step_levels);
    add_series("joint", options.mesh_levels, options.step_levels);
    if (has_kernel_) add_kernel_series();
  }

  Convergence run() {
    result_.folder = study_folder(options_.study, "converge", scene_.file);
    if (options_.store) {
      result_.stored = accuracy_path(scene_.file);
      require_replaceable(result_.stored);
    }
    Pool pool(comm_, options_.study.ranks_per_run);
    OpenStudy study = open_study(comm_, result_.folder, "converge", {"convergence.json", "fields/"},
                                 options_.study, plan_json(), columns());
    in_folder(*study.folder, [&] {
      run_in(pool, std::move(study.kept));
      Json summary{{"status", "completed"}, {"runs", result_.runs.size()}};
      add_identity(summary, meshes_);
      study.folder->finish(summary);
    });
    return result_;
  }

 private:
  void run_in(Pool& pool, Table kept) {
    ResultsFile results(comm_, result_.folder + "/results.csv", std::move(kept));
    run_missing(pool, results);
    results.finish();
    read_back();
    for (const Series& series : result_.series) {
      std::vector<Extrapolation> of_series;
      for (std::size_t q = 0; q < result_.quantities.size(); ++q) {
        std::vector<double> values;
        for (const std::size_t run : series.runs) values.push_back(result_.runs[run].values[q]);
        of_series.push_back(
            series.name == "kernel"
                ? extrapolate_known(values[0], values[1], kernel_ratio, kernel_order)
                : extrapolate(values, ratio, series.name == "step" ? step_order : mesh_order));
      }
      result_.extrapolations.push_back(std::move(of_series));
    }
    compare_fields();
    check_unused_options();
    const bool has_file = !meshes_.empty();
    report(comm_, scene_, result_, has_file ? meshes_.begin()->second : "", options_.study.quiet);
    if (options_.study.picture) draw(comm_, "converge.py", result_.folder, options_.study.quiet);
  }

  /// Collective. Found before hours of work, not after.
  void require_replaceable(const std::string& path) const {
    agree_after(comm_, [&] {
      if (rank_of(comm_) == 0 && std::filesystem::exists(path)) {
        require_own_accuracy(path, read_file(path));
      }
    });
  }

  void add_series(const std::string& name, int mesh_levels, int step_levels) {
    const int n = std::max(mesh_levels, step_levels);
    if (n < 2 || (name == "joint" && std::min(mesh_levels, step_levels) < 2)) return;
    const int levels = name == "joint" ? std::min(mesh_levels, step_levels) : n;
    Series series{name, {}};
    for (int i = 0; i < levels; ++i) {
      const Level level{scene_.mesh.refine + (mesh_levels > 1 ? i : 0),
                        scene_.time.step / (step_levels > 1 ? std::pow(ratio, i) : 1)};
      series.runs.push_back(run_at(level));
    }
    result_.series.push_back(std::move(series));
  }

  /// On the finest mesh: the smaller kernel asks more of it.
  void add_kernel_series() {
    const Level finest{scene_.mesh.refine + options_.mesh_levels - 1, scene_.time.step};
    Level smaller = finest;
    smaller.kernel = 1 / kernel_ratio;
    check_dimension(with(smaller), scene_.document);
    result_.series.push_back({"kernel", {run_at(finest), run_at(smaller)}});
  }

  [[nodiscard]] std::size_t run_at(const Level& level) {
    auto run = std::ranges::find(result_.runs, level, &LevelRun::level);
    if (run == result_.runs.end()) run = result_.runs.insert(run, {level, 0, 0, {}});
    return static_cast<std::size_t>(run - result_.runs.begin());
  }

  [[nodiscard]] Scene with(const Level& level) const {
    Scene scene = scene_;
    scene.mesh.refine = level.refine;
    scene.time.step = level.step;
    for (auto& needle : scene.needles) needle.space.kernel_radius *= level.kernel;
    return scene;
  }

  [[nodiscard]] std::string fields_folder() const { return result_.folder + "/fields"; }
  [[nodiscard]] std::string fields_path(std::size_t run) const {
    return fields_folder() + "/" + id_of(run) + ".cbor";
  }
  static std::string id_of(std::size_t run) {
    char text[24];
    std::snprintf(text, sizeof text, "%05zu", run);
    return text;
  }

  [[nodiscard]] Json plan_json() const {
    Json plan{{"study", "converge"},
              {"mesh_levels", options_.mesh_levels},
              {"step_levels", options_.step_levels},
              {"quantities", result_.quantities}};
    for (const auto& run : result_.runs) {
      plan["levels"].push_back({{"refine", run.level.refine}, {"step", run.level.step}});
      if (has_kernel_) plan["levels"].back()["kernel"] = run.level.kernel;
    }
    Scene scene = scene_;
    scene.output = {};
    scene.expect.clear();
    plan["scene"] = to_yaml(scene);
    add_identity(plan, meshes_);
    return plan;
  }

  [[nodiscard]] std::vector<std::string> columns() const {
    std::vector<std::string> names{"run", "status", "refine", "step [s]"};
    if (has_kernel_) names.emplace_back("kernel");
    names.push_back(n_cells_);
    names.insert(names.end(), result_.quantities.begin(), result_.quantities.end());
    names.insert(names.end(), {"error", "wall_time [s]"});
    return names;
  }

  // The expensive levels first, so that no group is left with a long one at the end.
  [[nodiscard]] std::vector<int> missing(const Table& table) const {
    std::vector<int> runs;
    for (std::size_t i = 0; i < result_.runs.size(); ++i) {
      const bool done = std::ranges::any_of(
          table.rows, [&](const auto& row) { return row[0] == id_of(i) && row[1] == "done"; });
      if (!done) runs.push_back(static_cast<int>(i));
    }
    std::ranges::stable_sort(runs, std::greater(), [&](int run) { return cost(run); });
    return runs;
  }

  [[nodiscard]] double cost(int run) const {
    const Level& level = result_.runs[static_cast<std::size_t>(run)].level;
    return std::pow(2.0, scene_.dim() * level.refine) / level.step;
  }

  void run_missing(Pool& pool, ResultsFile& results) {
    const auto tasks = missing(results.table());
    double total = 0;
    for (const int task : tasks) total += cost(task);
    double done = 0;
    int n_done = 0;
    double own_cost = 0;
    Progress progress(comm_, options_.study.quiet);
    const auto show = [&](double own) {
      if (!progress.due()) return;
      progress.update((done + own * own_cost) / total,
                      std::to_string(n_done) + " of " + std::to_string(tasks.size()) + " levels");
    };
    const bool finished = pool.run(
        tasks,
        [&](int task, MPI_Comm group, const Poll& poll) {
          own_cost = cost(task);
          const Level& level = result_.runs[static_cast<std::size_t>(task)].level;
          progress.note("level with mesh.refine " + std::to_string(level.refine) +
                        " and time.step " + brief(level.step) + " s");
          return measure(static_cast<std::size_t>(task), group, poll);
        },
        [&](int task, const std::string& text) {
          results.append({row_of(static_cast<std::size_t>(task), Json::parse(text))});
          forget_checkpoint(result_.folder, id_of(static_cast<std::size_t>(task)));
          done += cost(task);
          ++n_done;
          show(0);
        },
        show);
    if (!finished) stop_study(comm_);
  }

  [[nodiscard]] std::optional<std::string> measure(std::size_t task,
                                                   MPI_Comm group,
                                                   const Poll& poll) const {
    const Scene scene = with(result_.runs[task].level);
    keep_scene(group, result_.folder, id_of(task), scene);
    std::vector<FieldSample> samples;
    std::size_t n_seeds = 0;
    const RunPlace place{checkpoint_path(result_.folder, id_of(task)), options_.study.quiet,
                         [&](Archive& archive) {
                           archive("samples", samples);
                           archive("n_seeds", n_seeds);
                         }};
    const StudyRun run =
        run_in_study(group, scene, meshes_, place, poll, [&](const Simulation& simulation) {
          const std::size_t now = simulation.seeds().size();
          if (now > n_seeds || (simulation.done() && now == 0)) {
            samples.push_back(field_now(simulation));
          }
          n_seeds = now;
        });
    if (run.stopped) return std::nullopt;
    agree_after(group, [&] {
      if (rank_of(group) == 0 && run.error.empty()) write_fields(fields_path(task), samples);
    });
    Json values = Json::array();
    for (const auto& path : result_.quantities) {
      const auto value = find_number(run.summary, path);
      values.push_back(value ? Json(*value) : Json());
    }
    return Json{{"error", run.error},
                {"seconds", run.seconds},
                {"n_cells", run.error.empty() ? run.summary.at(n_cells_) : Json(0)},
                {"values", values}}
        .dump();
  }

  [[nodiscard]] std::vector<std::string> row_of(std::size_t task, const Json& result) const {
    const Level& level = result_.runs[task].level;
    const auto error = result["error"].get<std::string>();
    std::vector<std::string> row{id_of(task), error.empty() ? "done" : "failed",
                                 std::to_string(level.refine), exact(level.step)};
    if (has_kernel_) row.push_back(exact(level.kernel));
    row.push_back(std::to_string(result["n_cells"].get<int>()));
    for (const Json& value : result["values"]) {
      row.push_back(value.is_number() ? exact(value.get<double>()) : "");
    }
    row.push_back(error);
    row.push_back(exact(result["seconds"].get<double>()));
    return row;
  }

  /// From the file, so that every rank has the same and earlier runs count like new ones.
  void read_back() {
    const std::string path = result_.folder + "/results.csv";
    const Table table = read_csv(path, read_on_all(comm_, path));
    const std::size_t first_value = table.column(n_cells_) + 1;
    for (const auto& row : table.rows) {
      LevelRun& run = result_.runs.at(std::stoul(row[0]));
      if (row[1] != "done") {
        throw NumericalError("converge: the level with mesh.refine " +
                             std::to_string(run.level.refine) + " and time.step " +
                             exact(1e3 * run.level.step) +
                             " ms failed: " + row[table.column("error")]);
      }
      run.n_cells = std::stoi(row[table.column(n_cells_)]);
      run.seconds = std::stod(row[table.column("wall_time [s]")]);
      run.values.clear();
      for (std::size_t q = 0; q < result_.quantities.size(); ++q) {
        run.values.push_back(std::stod(row[first_value + q]));
      }
    }
  }

  void compare_fields() {
    std::string failure;
    if (rank_of(comm_) == 0) {
      try {
        std::vector<std::vector<FieldSample>> samples;
        for (std::size_t i = 0; i < result_.runs.size(); ++i) {
          samples.push_back(read_fields(fields_path(i)));
        }
        for (const auto& sample : samples.front()) result_.moments.push_back(sample.time);
        for (const Series& series : result_.series) {
          auto& distances = result_.field_distances.emplace_back();
          const auto& fine = samples[series.runs.back()];
          for (std::size_t i = 0; i + 1 < series.runs.size(); ++i) {
            const auto& coarse = samples[series.runs[i]];
            auto& of_level = distances.emplace_back();
            for (std::size_t m = 0; m < fine.size(); ++m) {
              of_level.push_back(relative_distance(coarse[m], fine[m]));
            }
          }
        }
      } catch (const Error& error) {
        failure = error.what();
      }
    }
    agree_after(comm_, [&] {
      if (!failure.empty()) throw InputError(failure);
    });
  }

  MPI_Comm comm_;
  const Scene& scene_;
  const ConvergeOptions& options_;
  const std::string n_cells_ = "n_" + scene_.cells();
  const bool has_kernel_ = scene_.dim() == 3 && !scene_.needles.empty();
  Convergence result_;
  MeshFiles meshes_;
};

}  // namespace

Convergence converge(MPI_Comm comm, const Scene& scene, const ConvergeOptions& options) {
  return Study(comm, scene, options).run();
}

}  // namespace stylet
