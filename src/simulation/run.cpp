#include "stylet/simulation/run.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/output/progress.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/writer.hpp"
#include "stylet/simulation/recorder.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>

namespace stylet {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string output_folder(const Scene& scene, const RunOptions& options) {
  if (!options.output.empty()) return options.output;
  if (!scene.output.directory.empty()) return scene.output.directory;
  return "out/" + std::filesystem::path(scene.file).stem().string();
}

std::string progress_text(const Simulation& simulation, const StepRecord& step) {
  char text[200];
  if (const Needle* needle = simulation.needle(); needle != nullptr) {
    std::snprintf(text, sizeof text, "t %.3f s  %s  tip %.2f mm deep  force %.2f N", step.t,
                  name_of(needle->phase()),
                  1e3 * (needle->motion().tip() - needle->motion().skin()),
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
    return with_uncertainty(value, {entry["mesh"].get<double>(), entry["step"].get<double>()},
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
    summary["uncertainty"][quantity] = {
        {"mesh", u->mesh}, {"step", u->step}, {"total", u->total()}};
  }
}

void print(const Scene& scene, const RunOutcome& outcome) {
  const auto& summary = outcome.summary;
  bool known = true;
  for (std::size_t i = 0; i < summary["seeds"].size(); ++i) {
    const auto& seed = summary["seeds"][i];
    if (!seed.contains("placement_error")) continue;
    const std::string quantity = "seeds." + std::to_string(i) + ".placement_error";
    known = known && summary.contains("uncertainty") && summary["uncertainty"].contains(quantity);
    std::printf("placement error of the seed for '%s': %s\n",
                seed["target"].get<std::string>().c_str(),
                shown_with(summary, quantity, 1e3, "mm").c_str());
  }
  if (summary.contains("peak_needle_force")) {
    std::printf("peak needle force: %s\n",
                shown_with(summary, "peak_needle_force", 1, "N").c_str());
  }
  if (!known) {
    std::printf(
        "note: numerical error unknown: no convergence study of this scene at this mesh and step "
        "(stylet converge --store)\n");
  }
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
  std::printf("%d steps on %d triangles and %d rank%s in %.2f s\n", summary["steps"].get<int>(),
              summary["n_triangles"].get<int>(), summary["n_ranks"].get<int>(),
              summary["n_ranks"].get<int>() == 1 ? "" : "s", total);
  std::printf("files in %s: summary.json, scene.yaml%s%s\n", outcome.folder.c_str(),
              scene.output.history ? ", history.csv" : "",
              scene.output.snapshots ? ", snapshots.h5 (open snapshots.xdmf in ParaView)" : "");
}

}  // namespace

std::string resolved_text(Scene scene) {
  if (auto* file = std::get_if<std::string>(&scene.mesh.source)) {
    const auto folder = std::filesystem::absolute(scene.file).parent_path();
    *file = (folder / *file).lexically_normal().string();
  }
  return to_yaml(scene);
}

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
  prepare_folder(comm, outcome.folder, options.force);
  write_text_atomically(comm, outcome.folder + "/scene.yaml", resolved_text(scene));
  const std::string summary_path = outcome.folder + "/summary.json";
  book("set_up");
  Recorder recorder(comm, simulation, outcome.folder);
  write_summary(comm, summary_path, summarise(comm, simulation, "running", walls));
  book("output");
  {
    Progress progress(comm, options.quiet);
    try {
      while (!simulation.done()) {
        const StepRecord step = simulation.step();
        if (simulation.counts().steps == 1) check_unused_options();
        if (step.sub_steps == 0) continue;
        book(phase_of(simulation));
        recorder.record(simulation, step);
        book("output");
        if (progress.due()) {
          progress.update(simulation.fraction(), progress_text(simulation, step));
        }
      }
    } catch (const NumericalError& error) {
      recorder.finish(simulation);
      outcome.summary = summarise(comm, simulation, "failed", walls);
      outcome.summary["error"] = error.what();
      write_summary(comm, summary_path, outcome.summary);
      throw;
    }
  }
  recorder.finish(simulation);
  book("output");
  outcome.summary = summarise(comm, simulation, "completed", walls);
  add_uncertainty(scene, options, outcome.summary);
  outcome.failed_expectations = check_expectations(scene, outcome.summary);
  write_summary(comm, summary_path, outcome.summary);
  if (rank_of(comm) == 0 && !options.quiet) print(scene, outcome);
  return outcome;
}

}  // namespace stylet
