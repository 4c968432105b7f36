#include "stylet/study/study_run.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/simulation/model.hpp"
#include "stylet/simulation/recorder.hpp"

#include <algorithm>
#include <chrono>
#include <span>

namespace stylet {

namespace {

/// Collective. A mesh that cannot be read now could be when the study began.
void require_same_mesh(MPI_Comm comm, const Scene& scene, const MeshFiles& meshes) {
  try {
    for (const auto& [name, now] : mesh_files(comm, std::span(&scene, 1))) {
      const auto studied = meshes.find(name);
      if (studied != meshes.end() && studied->second == now) continue;
      throw IoError(mesh_path(scene) +
                    ": was changed while the study ran; with the file as it was, "
                    "--resume goes on");
    }
  } catch (const Error& error) {
    throw IoError(error.what());
  }
}

}  // namespace

StudyRun run_in_study(MPI_Comm comm,
                      const Scene& scene,
                      const MeshFiles& meshes,
                      const Poll& poll,
                      const Inspect& inspect) {
  require_same_mesh(comm, scene, meshes);
  const auto start = std::chrono::steady_clock::now();
  StudyRun run;
  try {
    Simulation simulation(comm, scene, false);
    while (!simulation.done()) {
      simulation.step();
      if (inspect) inspect(simulation);
      poll(simulation.fraction());
    }
    run.summary = summarise(comm, simulation, "completed", {});
  } catch (const Error& error) {
    if (error.code() != ExitCode::bad_input && error.code() != ExitCode::numerical) throw;
    const std::string unreadable = mesh_path(scene) + ": cannot be read";
    if (std::string(error.what()).starts_with(unreadable)) throw IoError(error.what());
    run.error = one_line(error.what());
  }
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  require_same_mesh(comm, scene, meshes);
  return run;
}

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

}  // namespace stylet
