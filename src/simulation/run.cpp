#include "stylet/simulation/run.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/base/text.hpp"
#include "stylet/image/file.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/output/progress.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/writer.hpp"
#include "stylet/simulation/checkpoint.hpp"
#include "stylet/simulation/picture.hpp"
#include "stylet/simulation/recorder.hpp"
#include "stylet/simulation/score.hpp"
#include "stylet/simulation/start.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

namespace stylet {

namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string progress_text(const Simulation& simulation, const StepRecord& step) {
  char text[200];
  if (const Needle* needle = simulation.needle(); needle != nullptr) {
    std::snprintf(text, sizeof text, "t %.3f s  %s  tip %.2f mm deep  force %.2f N", step.t,
                  name_of(needle->phase()), 1e3 * (needle->tip() - needle->skin()),
                  step.needle.forces.total());
  } else {
    std::snprintf(text, sizeof text, "t %.4g s", step.t);
  }
  return text;
}

const char* phase_of(const Simulation& simulation) {
  const Needle* needle = simulation.needle();
  return needle != nullptr ? name_of(needle->phase()) : "stepping";
}

int check_expectations(const Scene& scene, nlohmann::ordered_json& summary) {
  int failed = 0;
  for (const auto& expectation : scene.expect) {
    const auto value = find_number(summary, expectation.quantity);
    const bool met = value && *value >= expectation.min && *value <= expectation.max;
    nlohmann::ordered_json entry{{"quantity", expectation.quantity}, {"met", met}};
    entry["value"] = value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
    if (std::isfinite(expectation.min)) entry["min"] = expectation.min;
    if (std::isfinite(expectation.max)) entry["max"] = expectation.max;
    summary["expectations"].push_back(entry);
    failed += met ? 0 : 1;
  }
  return failed;
}

/// A number of the summary with what is known of its error.
std::string shown_with(const nlohmann::ordered_json& summary,
                       const std::string& quantity,
                       double factor,
                       const std::string& unit) {
  const double value = find_number(summary, quantity).value_or(0);
  if (summary.contains("uncertainty") && summary["uncertainty"].contains(quantity)) {
    const auto& entry = summary["uncertainty"][quantity];
    return with_uncertainty(
        value,
        {entry["mesh"].get<double>(), entry["step"].get<double>(), entry.value("kernel", 0.0)},
        factor, unit);
  }
  char text[40];
  std::snprintf(text, sizeof text, "%.3f %s", factor * value, unit.c_str());
  return text;
}

void add_uncertainty(const Scene& scene,
                     const RunOptions& options,
                     nlohmann::ordered_json& summary) {
  if (!options.accuracy) return;
  std::vector<std::string> quantities{"peak_needle_force"};
  for (std::size_t i = 0; i < summary["seeds"].size(); ++i) {
    quantities.push_back("seeds." + std::to_string(i) + ".placement_error");
  }
  for (const auto& quantity : quantities) {
    const auto u = options.accuracy->of(quantity, scene.mesh.refine, scene.time.step);
    if (!u) continue;
    summary["uncertainty"][quantity] = json_of(*u);
  }
}

void print(const Scene& scene,
           const RunOptions& options,
           const RunOutcome& outcome,
           const std::optional<Score>& score) {
  const auto& summary = outcome.summary;
  bool known = true;
  for (std::size_t i = 0; i < summary["seeds"].size(); ++i) {
    const auto& seed = summary["seeds"][i];
    if (!seed.contains("placement_error")) continue;
    const std::string quantity = "seeds." + std::to_string(i) + ".placement_error";
    known = known && summary.contains("uncertainty") && summary["uncertainty"].contains(quantity);
    std::printf("placement error of the seed for '%s': %s%s\n",
                seed["target"].get<std::string>().c_str(),
                shown_with(summary, quantity, 1e3, "mm").c_str(),
                distrust(seed["turned_over"].get<int>()).c_str());
  }
  if (summary.contains("peak_needle_force")) {
    std::printf("peak needle force: %s\n",
                shown_with(summary, "peak_needle_force", 1, "N").c_str());
  }
  if (!known || !options.accuracy_missing.empty()) {
    std::printf("note: numerical error unknown: %s (stylet converge --store)\n",
                options.accuracy_missing.empty()
                    ? "no convergence study of this scene at this mesh and step"
                    : options.accuracy_missing.c_str());
  }
  if (score) std::fputs(text_of(*score).c_str(), stdout);
  for (const auto& note : summary["notes"]) {
    std::printf("note: %s\n", note.get<std::string>().c_str());
  }
  if (summary.contains("expectations")) {
    for (const auto& e : summary["expectations"]) {
      std::printf("expected %s: %s (value %s)\n", e["quantity"].get<std::string>().c_str(),
                  e["met"].get<bool>() ? "met" : "NOT MET", e["value"].dump().c_str());
    }
  }
  const auto& walls = summary["wall_times"];
  double total = 0;
  for (const auto& [phase, seconds] : walls.items()) total += seconds.get<double>();
  std::printf("%lld steps on %d %s and %d rank%s in %.2f s\n", summary["steps"].get<long long>(),
              summary["n_" + scene.cells()].get<int>(), scene.cells().c_str(),
              summary["n_ranks"].get<int>(), summary["n_ranks"].get<int>() == 1 ? "" : "s", total);
  std::printf("files in %s: summary.json, scene.yaml%s%s\n", outcome.folder.c_str(),
              scene.output.history ? ", history.csv" : "",
              scene.output.snapshots ? ", snapshots.h5 (open snapshots.xdmf in ParaView)" : "");
}

Contents contents_of(const Scene& scene) {
  Contents contents{"run", {"scene.yaml"}, {}};
  if (scene.image) contents.names.emplace_back("image.png");
  if (scene.output.history) contents.names.emplace_back("history.csv");
  if (scene.output.snapshots) {
    for (const char* name : {"snapshots.h5", "snapshots.xdmf", "snapshots_needle.xdmf"}) {
      contents.names.emplace_back(name);
    }
  }
  return contents;
}

/// What any rank has learned in a step.
struct News {
  int signal = 0;    ///< that asked the run to stop
  bool due = false;  ///< a checkpoint
};

/// Collective. Ends the run where its files cannot be written.
News hear(MPI_Comm comm, Recorder& recorder, OutputFolder& folder, bool due) {
  int news[4] = {StatusFile::signal(), recorder.failed() ? 1 : 0, due ? 1 : 0,
                 folder.is_lost() ? 1 : 0};
  if (size_of(comm) > 1) MPI_Allreduce(MPI_IN_PLACE, news, 4, MPI_INT, MPI_MAX, comm);
  if (news[3] != 0) {
    throw IoError(folder.path() + ": was removed or replaced while the run wrote to it");
  }
  if (news[1] != 0) recorder.close();
  return {news[0], news[2] != 0};
}

/// Collective. Closes the files of a run that ended with an error, with a last snapshot where that
/// is likely to succeed. Whether the simulation can still be asked.
bool close_after(const std::exception& failure,
                 const Simulation& simulation,
                 std::optional<Recorder>& recorder) {
  const auto* error = dynamic_cast<const Error*>(&failure);
  const bool stopped = dynamic_cast<const Stopped*>(&failure) != nullptr;
  if (error == nullptr && !stopped) return false;
  const bool whole =
      stopped || error->code() == ExitCode::numerical || error->code() == ExitCode::bad_input;
  try {
    if (recorder && whole) recorder->finish(simulation);
    if (recorder && !whole) recorder->close();
  } catch (const Error&) {  // the first failure is the one to tell
  }
  return whole || error->code() == ExitCode::io;
}

/// Collective. The text of a file in the output folder; empty if there is none.
std::string text_in(MPI_Comm comm, const std::string& path) {
  int there = rank_of(comm) == 0 && std::filesystem::exists(path) ? 1 : 0;
  MPI_Bcast(&there, 1, MPI_INT, 0, comm);
  return there != 0 ? read_on_all(comm, path) : std::string();
}

/// Collective. The summary of an earlier run in a folder that was completed; null without one.
Json completed_in(MPI_Comm comm, const std::string& folder) {
  Json summary = Json::parse(text_in(comm, folder + "/summary.json"), nullptr, false);
  const bool is_completed = summary.is_object() && summary.value("status", "") == "completed";
  return is_completed ? summary : Json();
}

RunOutcome completed_before(MPI_Comm comm,
                            Json summary,
                            RunOutcome outcome,
                            const RunOptions& options) {
  for (const auto& e : summary.value("expectations", Json::array())) {
    if (!e.value("met", false)) ++outcome.failed_expectations;
  }
  outcome.summary = std::move(summary);
  if (rank_of(comm) == 0 && !options.quiet) {
    std::printf("%s: the run is completed already\n", outcome.folder.c_str());
  }
  return outcome;
}

/// Throws InputError for a part that would end before it begins.
void require_later(const RunOptions& options, const Simulation& simulation) {
  if (!options.until || *options.until > simulation.time() || simulation.done()) return;
  throw InputError("--until " + exact(*options.until) + " s: the run goes on at t = " +
                   exact(simulation.time()) + " s; allowed: more than that");
}

/// Collective. Where a run goes on; none where it begins.
std::optional<LoadedCheckpoint> go_on_from(MPI_Comm comm,
                                           Checkpoints& checkpoints,
                                           const CheckpointAbout& about,
                                           const Scene& scene,
                                           const RunOptions& options,
                                           const std::string& folder) {
  std::vector<std::string> notes;
  auto loaded = checkpoints.newest(notes);
  if (loaded && !loaded->place) {
    throw InputError(loaded->path +
                     ": was written by a study, and knows no files of a run; move it away");
  }
  if (loaded) {
    require_same_physics(loaded->about, loaded->path, scene, about);
    require_same_files(*loaded, scene);
    notes.push_back("going on at t = " + exact(loaded->about.time) + " s, after " +
                    std::to_string(loaded->about.steps) + " steps, from " + loaded->path);
  } else {
    const std::string before = folder + "/scene.yaml";
    if (const auto text = text_in(comm, before); !text.empty()) {
      require_same_physics({text, about.mesh, about.options}, before, scene, about);
    }
    if (!completed_in(comm, folder).is_null()) {
      throw InputError(
          folder +
          ": holds a completed run that has left no checkpoint to go on from; "
          "output.checkpoint.at_end leaves one; use --force to run it anew, or another "
          "folder with --output");
    }
    notes.push_back("no checkpoint in " + folder + ": the run begins at its beginning");
  }
  if (rank_of(comm) == 0 && !options.quiet) {
    for (const auto& note : notes) std::printf("%s\n", note.c_str());
  }
  return loaded;
}

}  // namespace

RunOutcome run(MPI_Comm comm, const Scene& scene, const RunOptions& options) {
  RunOutcome outcome;
  outcome.folder = output_folder(scene, options);
  std::map<std::string, double> walls;
  auto mark = Clock::now();
  const auto book = [&](const std::string& phase) {
    walls[phase] += seconds_since(mark);
    mark = Clock::now();
  };
  Simulation simulation(comm, scene, scene.output.history);
  const std::string resolved = resolved_text(scene);
  std::optional<Picture> image;
  if (scene.image) {
    agree_after(comm, [&] { image = picture_of(simulation.scene(), simulation.mesh()); });
  }
  const auto summary_now = [&](const std::string& status) {
    Json summary = summarise(comm, simulation, status, walls);
    summary["fingerprints"]["scene"] = fingerprint(resolved);  // of scene.yaml beside it
    if (image) {
      summary["image"] = {{"origin", {image->origin.x, image->origin.y}},
                          {"size", {image->size.x, image->size.y}},
                          {"shadow", scene.image->shadow}};
    }
    return summary;
  };
  const CheckpointAbout about{resolved, simulation.numbered().file_fingerprint, deciding_options()};
  const Earlier earlier = options.force    ? Earlier::replace
                          : options.resume ? Earlier::keep
                                           : Earlier::refuse;
  if (options.force) require_start_kept(scene, outcome.folder);
  if (!options.resume) require_later(options, simulation);
  OutputFolder folder(comm, outcome.folder, contents_of(scene), earlier, OnSignal::tell);
  if (options.resume) {
    Json before = completed_in(comm, outcome.folder);
    Json now = before.is_null() || options.until ? Json() : summary_now("completed");
    const auto is_same = [&](const char* what) { return before.value(what, Json()) == now[what]; };
    if (now.is_object() && is_same("fingerprints") && is_same("solver_options")) {
      return completed_before(comm, std::move(before), std::move(outcome), options);
    }
  }
  Checkpoints checkpoints(comm, folder, scene.output);
  std::optional<Recorder> recorder;
  const auto write_checkpoint = [&](bool goes_on) {
    book("output");
    CheckpointAbout now = about;
    now.wall_times = walls;
    now.summary = summary_text(summary_now("running"));
    checkpoints.write(simulation, *recorder, std::move(now), goes_on);
    book("checkpoints");
  };
  RecorderPlace place;
  if (options.resume) {  // what is refused here leaves all as it was, and what became of it
    if (auto loaded = go_on_from(comm, checkpoints, about, scene, options, outcome.folder)) {
      simulation.restore(std::move(loaded->state));
      require_at(simulation, *loaded);
      place = std::move(*loaded->place);
      walls = std::move(loaded->about.wall_times);
    }
  }
  if (options.resume) require_later(options, simulation);
  try {
    folder.go_on(summary_now("running"));
    write_text_atomically(comm, outcome.folder + "/scene.yaml", resolved);
    if (image) write_text_atomically(comm, outcome.folder + "/image.png", png_of(*image));
    book("set_up");
    recorder.emplace(comm, simulation, outcome.folder, place);
    book("output");
    Progress progress(comm, options.quiet);
    bool options_checked = false;
    while (!simulation.done()) {
      const StepRecord step = simulation.step();
      if (!std::exchange(options_checked, true)) check_unused_options();
      if (step.sub_steps > 0) {
        book(phase_of(simulation));
        recorder->record(simulation, step);
        book("output");
      }
      const News news = hear(comm, *recorder, folder, checkpoints.due(simulation.counts().steps));
      const bool ends = options.until && simulation.time() >= *options.until && !simulation.done();
      if (news.signal != 0 || ends) {
        write_checkpoint(false);
        const std::string name = news.signal != 0 ? ::sigabbrev_np(news.signal) : "";
        if (!name.empty()) throw Stopped(news.signal, (name + "; go on with --resume").c_str());
        break;
      }
      if (news.due) write_checkpoint(!simulation.done());
      if (progress.due()) progress.update(simulation.fraction(), progress_text(simulation, step));
    }
    const bool at_end = scene.output.checkpoint && scene.output.checkpoint->at_end;
    if (simulation.done() && at_end) write_checkpoint(false);
    recorder->finish(simulation);
    book("output");
    outcome.summary = summary_now(simulation.done() ? "completed" : "stopped");
    if (simulation.done()) {
      add_uncertainty(scene, options, outcome.summary);
      outcome.failed_expectations = check_expectations(scene, outcome.summary);
    }
    folder.finish(outcome.summary);
  } catch (const std::exception& error) {
    Json left;
    if (all_here(comm) && close_after(error, simulation, recorder)) left = summary_now("failed");
    const auto* known = dynamic_cast<const Error*>(&error);
    if (known != nullptr && known->code() == ExitCode::io) {
      const IoError advised(with_next_step(error.what()));
      folder.fail(advised, left);
      throw advised;
    }
    folder.fail(error, left);
    throw;
  }
  std::optional<Score> score;
  if (scene.procedure && simulation.done()) score = score_of(simulation);
  if (rank_of(comm) == 0 && !options.quiet) print(scene, options, outcome, score);
  return outcome;
}

}  // namespace stylet
