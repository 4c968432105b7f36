#include "stylet/simulation/inspect.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/scene/loader.hpp"
#include "stylet/simulation/checkpoint.hpp"
#include "stylet/simulation/point_text.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

std::string place(const std::vector<double>& x) {
  std::vector<std::string> numbers;
  for (const double number : x) numbers.push_back(brief(1e3 * number));
  return "(" + join(numbers) + ") mm";
}

std::string text_of(const LoadedCheckpoint& loaded) {
  const CheckpointAbout& about = loaded.about;
  const Json summary = Json::parse(about.summary, nullptr, false);
  std::string text = loaded.path + ": t = " + brief(about.time) + " s, after " +
                     std::to_string(about.steps) + " steps\n";
  text += "written   " + about.written + " by stylet " + about.program + " on " +
          std::to_string(about.n_ranks) + (about.n_ranks == 1 ? " rank\n" : " ranks\n");
  text += "scene     " + summary.value("scene", "") + ", fingerprint " +
          fingerprint(about.scene).substr(0, 12) + "\n";
  text += "mesh      " + std::to_string(summary.value("n_nodes", 0)) + " nodes, " +
          (summary.contains("n_tetrahedra")
               ? std::to_string(summary.value("n_tetrahedra", 0)) + " tetrahedra"
               : std::to_string(summary.value("n_triangles", 0)) + " triangles");
  text += (about.mesh.empty() ? "" : ", file's fingerprint " + about.mesh.substr(0, 12)) + "\n";
  if (!about.phase.empty()) {
    std::vector<double> tip{about.tip.x, about.tip.y};
    if (summary.contains("n_tetrahedra")) tip.push_back(about.tip.z);
    text += "needle    " + about.phase + ", its tip at " + place(tip) + "\n";
  }
  for (const Json& seed : summary.value("seeds", Json::array())) {
    text += "seed      of " + seed.value("needle", "") +
            " at t = " + brief(seed.value("implanted_at", 0.0)) + " s, in the tissue at " +
            place(seed["reference"].get<std::vector<double>>());
    text += (seed.contains("target") ? ", for " + seed.value("target", "") : "") + "\n";
  }
  return text;
}

/// Collective. What a run of the scene would write at this moment.
void write_snapshot(MPI_Comm comm, const LoadedCheckpoint& loaded, const std::string& path) {
  const Scene scene =
      load_scene(loaded.path, loaded.about.scene, {"output.history=false", "output.snapshots=1 s"});
  Simulation simulation(comm, scene, false);
  simulation.restore(loaded.state);
  OutputFolder folder(comm, path,
                      {"inspect", {"snapshots.h5", "snapshots.xdmf", "snapshots_needle.xdmf"}, {}},
                      Earlier::refuse, OnSignal::end);
  in_folder(folder, [&] {
    Recorder(comm, simulation, path).close();
    Json summary = Json::parse(loaded.about.summary, nullptr, false);
    summary["status"] = "completed";
    folder.finish(summary);
  });
}

}  // namespace

std::string inspect(MPI_Comm comm, const std::string& checkpoint, const std::string& snapshot) {
  std::string fault;
  const auto loaded = load_checkpoint(comm, checkpoint, fault);
  if (!loaded) throw InputError(checkpoint + ": is no whole checkpoint: " + fault);
  if (snapshot.empty()) return text_of(*loaded);
  write_snapshot(comm, *loaded, snapshot);
  return text_of(*loaded) + "snapshot  in " + snapshot + "/snapshots.xdmf\n";
}

}  // namespace stylet
