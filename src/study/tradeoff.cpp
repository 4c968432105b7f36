#include "stylet/study/tradeoff.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/output/progress.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/loader.hpp"
#include "stylet/study/study_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* quantity = "seeds.0.placement_error";
constexpr const char* usual = "backward_euler";
constexpr const char* slow_limit = "quasi_static";
constexpr double patience = 10;  // times the usual way's time at equal mesh and step

/// Each differs from the usual way in one thing.
std::vector<Way> ways(bool has_shortcut) {
  const std::string implicit = "time.method=implicit";
  const std::string shortcut = has_shortcut ? "time.until=implanted" : "time.until=settled";
  const std::string euler = "time.scheme=backward_euler";
  const std::string explicit_steps = "time.method=explicit";
  return {
      {usual, {implicit, euler, shortcut}},
      {"generalised_alpha", {implicit, "time.scheme=generalised_alpha", shortcut}},
      {"average_acceleration", {implicit, "time.scheme=average_acceleration", shortcut}},
      {slow_limit, {"time.method=quasi_static", shortcut}},
      {"lagged_cutting", {implicit, euler, shortcut, "needles.0.cutting.law=lagged"}},
      {"quasi_static_lagged",
       {"time.method=quasi_static", shortcut, "needles.0.cutting.law=lagged"}},
      {"lumped_mass", {implicit, euler, shortcut, "tissue.mass=lumped"}},
      {"p1", {implicit, euler, shortcut, "tissue.formulation=p1"}},
      {"p1_averaged", {implicit, euler, shortcut, "tissue.formulation=p1_averaged"}},
      {"whole_procedure", {implicit, euler, "time.until=settled"}},
      {"explicit", {explicit_steps, shortcut}},
      // Explicit steps cannot bear stiffness damping; this one settles tissue within centiseconds.
      {"explicit_mass_damped",
       {explicit_steps, shortcut, "tissue.damping.stiffness_factor=null",
        "tissue.damping.mass_factor=200 1/s"}},
  };
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
    const bool has_shortcut = allows("time.until=implanted");
    for (const Way& way : ways(has_shortcut)) {
      if (way.name == "whole_procedure" && !has_shortcut) continue;  // all are
      for (int mesh = 0; mesh < options.mesh_levels; ++mesh) {
        for (int step = 0; step < options.step_levels; ++step) {
          // Explicit steps are cut to the stable one.
          if (way.name.starts_with("explicit") && step > 0) continue;
          plan(way, scene.mesh.refine + mesh, scene.time.step * std::pow(2.0, step));
        }
      }
    }
    plan({"reference", ways(has_shortcut).front().changes}, scene.mesh.refine + options.mesh_levels,
         scene.time.step / 2);
  }

  Tradeoff run() {
    result_.folder = study_folder(options_.study, "tradeoff", file_);
    ResultsFile results(comm_, result_.folder + "/results.csv",
                        open_study(comm_, result_.folder, options_.study, plan_json(), columns()));
    int n_rows = static_cast<int>(results.table().rows.size());
    check_mpi(MPI_Bcast(&n_rows, 1, MPI_INT, 0, comm_));
    Progress progress(comm_, options_.study.quiet);
    for (std::size_t i = static_cast<std::size_t>(n_rows); i < result_.runs.size(); ++i) {
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
    return result_;
  }

 private:
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

  void plan(const Way& way, int refine, double step) {
    TradeoffRun& run = result_.runs.emplace_back();
    run.way = way.name;
    run.refine = refine;
    run.step = step;
    auto& changes = overrides_.emplace_back(changes_);
    changes.insert(changes.end(), way.changes.begin(), way.changes.end());
    changes.push_back(level_changes(refine));
    changes.push_back("time.step=" + exact(step) + " s");
    changes.emplace_back("output.snapshots=null");
  }

  [[nodiscard]] Json plan_json() const {
    return {{"study", "tradeoff"},
            {"repeats", options_.repeats},
            {"changes", overrides_},
            {"scene", text_}};
  }

  static std::vector<std::string> columns() {
    return {"run",      "way",           "status",       "refine",
            "step [s]", "n_triangles",   "steps",        "placement_error",
            "error",    "wall_time [s]", "shortest [s]", "longest [s]"};
  }

  std::vector<std::string> row(std::size_t i,
                               const StudyRun& run,
                               std::vector<double> times) const {
    std::ranges::sort(times);
    char id[24];
    std::snprintf(id, sizeof id, "%05zu", i);
    const auto number = [&](const char* path) {
      const auto value = find_number(run.summary, path);
      return value ? exact(*value) : "";
    };
    return {id,
            result_.runs[i].way,
            run.error.empty() ? "done" : "failed",
            std::to_string(result_.runs[i].refine),
            exact(result_.runs[i].step),
            number("n_triangles"),
            number("sub_steps"),
            number(quantity),
            run.error,
            exact(times[times.size() / 2]),
            exact(times.front()),
            exact(times.back())};
  }

  std::vector<std::string> measure(std::size_t i, const Poll& poll) {
    constexpr double long_run = 10;  // s
    StudyRun run;
    std::vector<double> times;
    try {
      const Scene scene = load_scene(file_, text_, overrides_[i]);
      char id[24];
      std::snprintf(id, sizeof id, "%05zu", i);
      keep_scene(comm_, result_.folder, id, scene);
      double total = 0;
      while (static_cast<int>(times.size()) < options_.repeats && total < long_run) {
        const auto start = std::chrono::steady_clock::now();
        run = run_in_study(comm_, scene, [&](double own) {
          poll(own);
          stop_if_hopeless(i, std::chrono::steady_clock::now() - start);
        });
        // All ranks decide by the same clock.
        check_mpi(MPI_Bcast(&run.seconds, 1, MPI_DOUBLE, 0, comm_));
        times.push_back(run.seconds);
        total += run.seconds;
        if (!run.error.empty()) break;
      }
    } catch (const InputError& error) {
      run.error = one_line(error.what());
    }
    if (times.empty()) times.push_back(0);
    if (result_.runs[i].way == usual)
      usual_times_[{result_.runs[i].refine, result_.runs[i].step}] = times[0];
    return row(i, run, times);
  }

  /// Collective. Throws NumericalError: undamped tissue may never settle.
  void stop_if_hopeless(std::size_t i, std::chrono::duration<double> elapsed) {
    const TradeoffRun& run = result_.runs[i];
    const auto known = usual_times_.find({run.refine, run.step});
    if (run.way.starts_with("explicit") || known == usual_times_.end()) return;
    int hopeless = elapsed.count() > patience * known->second ? 1 : 0;
    check_mpi(MPI_Bcast(&hopeless, 1, MPI_INT, 0, comm_));  // by the same clock
    if (hopeless == 0) return;
    throw NumericalError("stopped after " + std::to_string(static_cast<int>(patience)) +
                         " times the time of " + usual);
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
    const TradeoffRun& reference = result_.runs.back();
    if (!reference.failure.empty()) {
      throw NumericalError("tradeoff: the reference run failed: " + reference.failure);
    }
    result_.reference = reference.value;
    for (TradeoffRun& run : result_.runs) run.error = std::abs(run.value - result_.reference);
    for (TradeoffRun& run : result_.runs) {
      for (const TradeoffRun& finer : result_.runs) {
        if (finer.way == run.way && finer.failure.empty() && finer.refine >= run.refine &&
            finer.step <= run.step) {
          run.safe_error = std::max(run.safe_error, finer.error);
        }
      }
    }
    for (TradeoffRun& run : result_.runs) {
      if (!run.failure.empty() || run.way == "reference") continue;
      run.on_front = std::ranges::none_of(result_.runs, [&](const TradeoffRun& other) {
        return other.failure.empty() && other.way != "reference" && other.seconds <= run.seconds &&
               other.safe_error <= run.safe_error &&
               (other.seconds < run.seconds || other.safe_error < run.safe_error);
      });
    }
  }

  MPI_Comm comm_;
  std::string file_;
  std::string text_;
  std::vector<std::string> changes_;
  const TradeoffOptions& options_;
  std::vector<std::vector<std::string>> overrides_;
  std::map<std::pair<int, double>, double> usual_times_;  ///< s, by refine and step; of this start
  Tradeoff result_;
};

std::string label(const TradeoffRun& run) {
  char text[100];
  std::snprintf(text, sizeof text, "%s, mesh.refine %d, step %.4g ms", run.way.c_str(), run.refine,
                1e3 * run.step);
  return text;
}

std::vector<const TradeoffRun*> front_of(const Tradeoff& result) {
  std::vector<const TradeoffRun*> front;
  for (const auto& run : result.runs) {
    if (run.on_front) front.push_back(&run);
  }
  std::ranges::sort(front, {}, &TradeoffRun::seconds);
  return front;
}

/// What inertia and damping do: the usual way against the quasi-static one at equal mesh and step.
std::optional<double> dynamic_share(const Tradeoff& result) {
  std::optional<double> largest;
  for (const auto& a : result.runs) {
    if (a.way != usual || !a.failure.empty()) continue;
    for (const auto& b : result.runs) {
      if (b.way != slow_limit || !b.failure.empty() || b.refine != a.refine || b.step != a.step)
        continue;
      largest = std::max(largest.value_or(0), std::abs(a.value - b.value));
    }
  }
  return largest;
}

std::vector<std::string> advice(const Tradeoff& result) {
  constexpr double wanted[] = {1e-3, 0.5e-3, 0.2e-3, 0.1e-3, 0.05e-3};
  std::vector<std::string> lines;
  const auto front = front_of(result);
  for (const double target : wanted) {
    const auto best =
        std::ranges::find_if(front, [&](const auto* run) { return run->safe_error <= target; });
    char text[200];
    if (best == front.end()) {
      std::snprintf(text, sizeof text, "for %g mm: none of these; refine further", 1e3 * target);
    } else {
      std::snprintf(text, sizeof text, "for %g mm: %s, %.3g s", 1e3 * target, label(**best).c_str(),
                    (*best)->seconds);
    }
    lines.emplace_back(text);
  }
  if (const auto share = dynamic_share(result)) {
    char text[120];
    std::snprintf(text, sizeof text,
                  "going dynamic changes the placement error by up to %.3f mm at this speed",
                  1e3 * *share);
    lines.emplace_back(text);
  }
  return lines;
}

Json json_of(const Tradeoff& result) {
  Json json{{"reference", result.reference}, {"advice", advice(result)}};
  for (const auto& run : result.runs) {
    Json entry{{"way", run.way}, {"refine", run.refine}, {"step", run.step}};
    if (run.failure.empty()) {
      entry.update({{"placement_error", run.value},
                    {"error", run.error},
                    {"safe_error", run.safe_error},
                    {"seconds", run.seconds},
                    {"on_front", run.on_front}});
    } else {
      entry["failure"] = run.failure;
    }
    json["runs"].push_back(entry);
  }
  return json;
}

void print(const Tradeoff& result) {
  const TradeoffRun& finest = result.runs.back();
  std::printf(
      "reference: %.4f mm (%s, %.3g s)\n\nPareto front: nothing faster is as accurate; errors are "
      "the largest of a run and all finer ones "
      "of its way\n",
      1e3 * result.reference, label(finest).c_str(), finest.seconds);
  std::printf("%9s  %10s  %16s  %s\n", "time (s)", "error (mm)", "digits a second", "");
  for (const TradeoffRun* run : front_of(result)) {
    const double digits =
        std::log10(result.reference / std::max(run->safe_error, 1e-12 * result.reference));
    std::printf("%9.3f  %10.4f  %16.3g  %s\n", run->seconds, 1e3 * run->safe_error,
                digits / run->seconds, label(*run).c_str());
  }
  std::printf("\n");
  for (const auto& line : advice(result)) std::printf("%s\n", line.c_str());
  std::string told;
  for (const auto& run : result.runs) {
    if (run.failure.empty() || run.way == told) continue;
    told = run.way;
    std::printf("%s failed: %s\n", run.way.c_str(), run.failure.c_str());
  }
  std::printf("files in %s: results.csv, tradeoff.json, scenes\n", result.folder.c_str());
}

}  // namespace

Tradeoff tradeoff(MPI_Comm comm,
                  const std::string& scene_file,
                  const std::string& text,
                  const std::vector<std::string>& changes,
                  const TradeoffOptions& options) {
  Tradeoff result = Study(comm, scene_file, text, changes, options).run();
  write_summary(comm, result.folder + "/tradeoff.json", json_of(result));
  if (rank_of(comm) == 0 && !options.study.quiet) print(result);
  if (options.study.picture) draw(comm, "tradeoff.py", result.folder, options.study.quiet);
  return result;
}

}  // namespace stylet
