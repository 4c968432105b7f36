#include "stylet/study/sweep.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/units.hpp"
#include "stylet/output/progress.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/scene/loader.hpp"
#include "stylet/scene/overrides.hpp"
#include "stylet/scene/quantities.hpp"
#include "stylet/study/campaign_plan.hpp"
#include "stylet/study/pool.hpp"
#include "stylet/study/study_run.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <set>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

std::string titled(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + " [" + unit + "]";
}

class Sweep {
 public:
  Sweep(MPI_Comm comm, const Campaign& campaign, const SweepOptions& options)
      : comm_(comm), campaign_(campaign), options_(options.study), part_(options.part) {
    if (part_ && options.join) {
      throw InputError("--part runs a part of the campaign, --join all of it: give one of them");
    }
    const auto folder = std::filesystem::path(campaign.file).parent_path();
    scene_file_ = (folder / campaign.scene).lexically_normal().string();
    scene_text_ = read_on_all(comm, scene_file_);
    Node document = parse_yaml(scene_file_, scene_text_);
    for (const auto& change : campaign.set) apply_override(document, scene_file_, change);
    plan_ = plan_runs(campaign, document);
    check_columns();
    check_outputs(scene_of(0));  // a wrong key or output strikes all runs
    meshes_ = mesh_files(comm, scenes_by_mesh());
  }

  SweepOutcome run(bool join) {
    SweepOutcome outcome;
    outcome.folder = study_folder(options_, "sweep", campaign_.file);
    if (part_) outcome.folder = part_folder(outcome.folder, *part_);
    Pool pool(comm_, options_.ranks_per_run);
    if (part_) mark_parent(comm_, study_folder(options_, "sweep", campaign_.file));
    StudyOptions how = options_;
    // A folder of parts holds no study yet; nothing of theirs is removed.
    if (join && !how.force) how.resume = true;
    OpenStudy study = open_study(comm_, outcome.folder, "sweep", {"statistics.json"}, how,
                                 plan_json(), columns());
    in_folder(*study.folder,
              [&] { run_in(*study.folder, std::move(study.kept), join, outcome, pool); });
    return outcome;
  }

 private:
  void run_in(OutputFolder& folder, Table kept, bool join, SweepOutcome& outcome, Pool& pool) {
    const auto start = std::chrono::steady_clock::now();
    kept = whole_runs(std::move(kept));
    if (join) join_parts(outcome.folder, kept);
    ResultsFile results(comm_, outcome.folder + "/results.csv", std::move(kept));
    const auto own = own_runs();
    const auto missing = missing_runs(own, results.table());
    outcome.runs = static_cast<int>(own.size());
    outcome.kept = outcome.runs - static_cast<int>(missing.size());
    Progress progress(comm_, options_.quiet);
    int done = 0;
    int failed = 0;
    const auto show = [&](double of_run) {
      if (!progress.due()) return;
      progress.update((done + of_run) / static_cast<double>(missing.size()),
                      std::to_string(done + outcome.kept) + " of " + std::to_string(outcome.runs) +
                          " runs" + (failed > 0 ? ", " + std::to_string(failed) + " failed" : ""));
    };
    const bool finished = pool.run(
        missing,
        [&](int task, MPI_Comm group, const Poll& poll) {
          return measure(task, group, outcome.folder, poll);
        },
        [&](int task, const std::string& text) {
          const Json result = Json::parse(text);
          results.append(rows_of(task, result));
          forget_checkpoint(outcome.folder, id_of(task));
          ++done;
          if (!result["error"].get<std::string>().empty()) ++failed;
          show(0);
        },
        show);
    if (!finished) stop_study(comm_);
    results.finish();
    const auto status = results.table().column("status");
    const auto& rows = results.table().rows;
    int n_failed = static_cast<int>(
        std::ranges::count_if(rows, [&](const auto& row) { return row[status] == "failed"; }));
    // Of a part all may fail: whether the campaign did, shows when the parts are joined.
    const bool none_left = !part_ && n_failed == static_cast<int>(rows.size());
    int shared[2] = {n_failed, none_left ? 1 : 0};
    MPI_Bcast(shared, 2, MPI_INT, 0, comm_);
    outcome.failed = shared[0];
    outcome.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (rank_of(comm_) == 0 && !options_.quiet) print(outcome, pool.n_groups());
    if (shared[1] == 1) {
      throw NumericalError("all runs of the campaign failed; " + outcome.folder +
                           "/results.csv has the reasons");
    }
    if (options_.picture && !part_) draw(comm_, "sweep.py", outcome.folder, options_.quiet);
    check_unused_options();
    Json summary{{"status", "completed"}, {"runs", outcome.runs}, {"failed", outcome.failed}};
    add_identity(summary, meshes_);
    folder.finish(summary);
  }

  /// A scene for each mesh and start file that the runs name.
  [[nodiscard]] std::vector<Scene> scenes_by_mesh() const {
    std::set<std::vector<std::string>> named;
    std::vector<Scene> scenes;
    for (const auto& run : plan_.runs) {
      std::vector<std::string> changes;
      std::ranges::copy_if(run.overrides, std::back_inserter(changes), [](const auto& change) {
        return change.starts_with("mesh") || change.starts_with("start");
      });
      if (!named.insert(changes).second) continue;
      changes.insert(changes.begin(), campaign_.set.begin(), campaign_.set.end());
      scenes.push_back(load_scene(scene_file_, scene_text_, changes));
    }
    return scenes;
  }

  /// Who reads results.csv goes by its titles.
  void check_columns() const {
    std::set<std::string> titles;
    for (const auto& title : columns()) {
      if (titles.insert(title).second) continue;
      throw InputError(campaign_.file + ": results.csv would have two columns '" + title +
                       "'; allowed: each output once, and variables and windows of other names");
    }
  }

  void check_outputs(const Scene& scene) const {
    std::vector<std::string> paths;
    std::string note;
    const Scene whole = with_procedure(comm_, scene, note);
    for (const auto& quantity : summary_quantities(whole)) paths.push_back(quantity.path);
    for (const auto& outputs : plan_.runs.front().outputs) {
      for (const auto& output : outputs) {
        if (std::ranges::find(paths, output) != paths.end()) continue;
        throw InputError(campaign_.file + ": key 'outputs': '" + output +
                         "' is no number of the summary of " + scene_file_ + "; the nearest is '" +
                         nearest(output, paths) + "'; all: " + join(paths));
      }
    }
    const bool on_the_way = std::ranges::any_of(campaign_.vary, &Variable::on_the_way);
    const std::string why = why_not_at_rest(scene);
    if (!on_the_way || why.empty()) return;
    throw InputError(campaign_.file +
                     ": on_the_way: seeds of one insertion are where those of many would be only "
                     "if the tissue goes back to rest, but " +
                     why);
  }

  [[nodiscard]] Scene scene_of(int task) const {
    std::vector<std::string> changes = campaign_.set;
    const auto& own = plan_.runs[static_cast<std::size_t>(task)].overrides;
    changes.insert(changes.end(), own.begin(), own.end());
    return load_scene(scene_file_, scene_text_, changes);
  }

  static std::string id_of(int task) {
    char text[16];
    std::snprintf(text, sizeof text, "%05d", task);
    return text;
  }

  [[nodiscard]] std::vector<std::string> columns() const {
    std::vector<std::string> names{"run", "point", "status"};
    for (std::size_t i = 0; i < campaign_.vary.size(); ++i) {
      names.push_back(titled(campaign_.vary[i].name, plan_.units[i]));
    }
    for (const Window& window : campaign_.average) {
      names.push_back(titled(window.name, split_quantity(window.width)->unit));
    }
    names.insert(names.end(), campaign_.outputs.begin(), campaign_.outputs.end());
    names.emplace_back("error");
    names.emplace_back("wall_time [s]");
    return names;
  }

  /// Says everything that the results depend on, and what the report needs.
  [[nodiscard]] Json plan_json() const {
    Json plan{{"title", campaign_.title},     {"design", name_of(campaign_.design)},
              {"samples", campaign_.samples}, {"seed", campaign_.seed},
              {"outputs", campaign_.outputs}, {"runs", plan_.runs.size()},
              {"shifts", plan_.shifts.size()}};
    for (std::size_t i = 0; i < campaign_.vary.size(); ++i) {
      const Variable& v = campaign_.vary[i];
      plan["variables"].push_back({{"name", v.name},
                                   {"column", titled(v.name, plan_.units[i])},
                                   {"from", v.from},
                                   {"to", v.to},
                                   {"scale", v.scale == Scale::linear ? "linear" : "log"}});
    }
    for (const auto& point : plan_.points) plan["points"].push_back(point.values);
    for (const auto& run : plan_.runs) plan["changes"].push_back(run.overrides);
    plan["set"] = campaign_.set;
    plan["scene"] = scene_text_;
    add_identity(plan, meshes_);
    return plan;
  }

  /// Adds the parts' results to what the folder had before; the first of a run counts.
  void join_parts(const std::string& folder, Table& table) const {
    for (const auto& part : parts_in(comm_, folder)) {
      const auto wanted = missing_runs(all_runs(), table);
      std::vector<std::string> taken;
      for (auto& row : whole_runs(read_study(comm_, part, plan_json(), columns())).rows) {
        if (std::ranges::none_of(wanted, [&](int run) { return row.front() == id_of(run); })) {
          continue;
        }
        taken.push_back(row.front());
        table.rows.push_back(std::move(row));
      }
      take_scenes(comm_, folder, part, taken);
    }
  }

  /// Without runs of which a kill left some rows only.
  [[nodiscard]] Table whole_runs(Table table) const {
    std::erase_if(table.rows, [&, all = table.rows](const auto& row) {
      const auto present =
          std::ranges::count(all, row.front(), [](const auto& r) { return r.front(); });
      const auto task = plain_number(row.front());
      if (!task || *task < 0 || *task >= static_cast<double>(plan_.runs.size())) return true;
      return static_cast<std::size_t>(present) !=
             plan_.runs[static_cast<std::size_t>(*task)].points.size();
    });
    return table;
  }

  [[nodiscard]] std::vector<int> all_runs() const {
    std::vector<int> runs(plan_.runs.size());
    std::iota(runs.begin(), runs.end(), 0);
    return runs;
  }

  [[nodiscard]] std::vector<int> own_runs() const {
    auto runs = all_runs();
    if (part_) std::erase_if(runs, [&](int run) { return !is_in(*part_, run); });
    return runs;
  }

  [[nodiscard]] static std::vector<int> missing_runs(const std::vector<int>& of,
                                                     const Table& table) {
    std::vector<int> missing;
    for (const int task : of) {
      const auto id = id_of(task);
      const auto is_own = [&](const auto& row) { return row.front() == id; };
      if (std::ranges::none_of(table.rows, is_own)) missing.push_back(task);
    }
    return missing;
  }

  [[nodiscard]] std::optional<std::string> measure(int task,
                                                   MPI_Comm group,
                                                   const std::string& folder,
                                                   const Poll& poll) const {
    const PlannedRun& planned = plan_.runs[static_cast<std::size_t>(task)];
    StudyRun run;
    try {
      const Scene scene = scene_of(task);
      keep_scene(group, folder, id_of(task), scene);
      const RunPlace place{checkpoint_path(folder, id_of(task)), options_.quiet};
      run = run_in_study(group, scene, meshes_, place, poll);
      if (run.stopped) return std::nullopt;
    } catch (const InputError& error) {
      run.error = one_line(error.what());
    }
    Json values = Json::array();
    for (const auto& outputs : planned.outputs) {
      Json of_point = Json::array();
      for (const auto& path : outputs) {
        const auto value = find_number(run.summary, path);
        of_point.push_back(value ? Json(*value) : Json());
        if (!value && run.error.empty()) run.error = "summary.json has no number '" + path + "'";
      }
      values.push_back(of_point);
    }
    return Json{{"error", run.error}, {"seconds", run.seconds}, {"values", values}}.dump();
  }

  [[nodiscard]] std::vector<std::vector<std::string>> rows_of(int task, const Json& result) const {
    const PlannedRun& planned = plan_.runs[static_cast<std::size_t>(task)];
    const auto error = result["error"].get<std::string>();
    std::vector<std::vector<std::string>> rows;
    for (std::size_t i = 0; i < planned.points.size(); ++i) {
      std::vector<std::string> row{id_of(task), std::to_string(planned.points[i]),
                                   error.empty() ? "done" : "failed"};
      const auto& values = plan_.points[planned.points[i]].values;
      for (std::size_t v = 0; v < values.size(); ++v) {
        row.push_back(number_of(values[v], plan_.units[v]));
      }
      for (std::size_t w = 0; w < campaign_.average.size(); ++w) {
        row.push_back(exact(split_quantity(plan_.shifts[planned.shift][w])->number));
      }
      for (const Json& value : result["values"][i]) {
        row.push_back(value.is_number() && error.empty() ? exact(value.get<double>()) : "");
      }
      row.push_back(error);
      char seconds[32];
      std::snprintf(seconds, sizeof seconds, "%.3f",
                    result["seconds"].get<double>() / static_cast<double>(planned.points.size()));
      row.emplace_back(seconds);
      rows.push_back(std::move(row));
    }
    return rows;
  }

  /// In the unit of the column; a text that is no such number stays.
  static std::string number_of(const std::string& text, const std::string& unit) {
    const auto quantity = split_quantity(text);
    if (quantity && quantity->unit == unit) return exact(quantity->number);
    if (!quantity || unit.empty()) return text;
    const Reading reading = read_quantity(text, unit);
    return reading.fault.empty() ? exact(reading.value) : text;
  }

  void print(const SweepOutcome& outcome, int n_groups) const {
    std::printf(
        "%d runs%s in %.1f s, %d at a time\n", outcome.runs,
        outcome.kept > 0 ? (", " + std::to_string(outcome.kept) + " of them kept,").c_str() : "",
        outcome.seconds, n_groups);
    if (outcome.failed > 0) {
      std::printf("%d rows have no result; column 'error' of results.csv has the reasons\n",
                  outcome.failed);
    }
    std::printf("files in %s: results.csv, plan.json, scenes\n", outcome.folder.c_str());
  }

  MPI_Comm comm_;
  const Campaign& campaign_;
  const StudyOptions& options_;
  const std::optional<Part>& part_;
  std::string scene_file_;
  std::string scene_text_;
  CampaignPlan plan_;
  MeshFiles meshes_;
};

}  // namespace

SweepOutcome sweep(MPI_Comm comm, const Campaign& campaign, const SweepOptions& options) {
  return Sweep(comm, campaign, options).run(options.join);
}

}  // namespace stylet
