#include "stylet/study/study_run.hpp"

#include "stylet/base/text.hpp"
#include "stylet/output/status_file.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/accuracy.hpp"
#include "stylet/simulation/checkpoint.hpp"
#include "stylet/simulation/model.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/recorder.hpp"
#include "stylet/simulation/run.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <span>

namespace stylet {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Collective. A mesh that cannot be read now could be when the study began.
void require_same_mesh(MPI_Comm comm, const Scene& scene, const MeshFiles& meshes) {
  try {
    for (const auto& [name, now] : mesh_files(comm, std::span(&scene, 1))) {
      const auto studied = meshes.find(name);
      if (studied != meshes.end() && studied->second == now) continue;
      throw IoError(path_in(scene, name) +
                    ": was changed while the study ran; with the file as it was, "
                    "--resume goes on");
    }
  } catch (const Error& error) {
    throw IoError(error.what());
  }
}

/// The state of one run in its file.
class StudyCheckpoint {
 public:
  StudyCheckpoint(MPI_Comm comm, const Scene& scene, const RunPlace& place, Simulation& simulation)
      : comm_(comm),
        scene_(scene),
        place_(place),
        simulation_(simulation),
        pace_(scene.output.checkpoint.value_or(CheckpointParameters{})) {}

  /// Collective. From where an earlier start has left it; `seconds` it took then. What is wrong with
  /// the file is no result of the scene.
  void go_on(double& seconds) {
    try {
      load(seconds);
    } catch (const Error& error) {
      throw IoError(std::string(error.what()) + "; without " + place_.checkpoint +
                    " --resume begins this run anew");
    }
  }

  /// Collective, after a step. Writes where it is due, or a signal stops the run: then it is true. Adds what
  /// that took to `seconds`.
  bool stops(const StudyRun& run, double so_far, double& seconds) {
    const long long steps = simulation_.counts().steps;
    std::array<int, 2> asked{StatusFile::signal() != 0 ? 1 : 0, pace_.due(steps) ? 1 : 0};
    if (size_of(comm_) > 1) {
      MPI_Allreduce(MPI_IN_PLACE, asked.data(), int{asked.size()}, MPI_INT, MPI_MAX, comm_);
    }
    const bool stop = asked[0] != 0;
    if (place_.checkpoint.empty() || simulation_.done() || (!stop && asked[1] == 0)) {
      return stop && !simulation_.done();
    }
    const auto start = Clock::now();
    write(run.seconds + so_far - seconds);
    seconds += seconds_since(start);
    return stop;
  }

 private:
  void load(double& seconds) {
    int there = 0;
    if (rank_of(comm_) == 0) there = std::filesystem::exists(place_.checkpoint) ? 1 : 0;
    MPI_Bcast(&there, 1, MPI_INT, 0, comm_);
    if (there == 0) return;
    std::string fault;
    auto loaded = load_checkpoint(comm_, place_.checkpoint, fault);
    if (!loaded) throw IoError(place_.checkpoint + " is not whole: " + fault);
    require_same_physics(loaded->about, place_.checkpoint, scene_, about());
    simulation_.restore(std::move(loaded->state));
    require_at(simulation_, *loaded);
    Archive learned({}, std::move(loaded->study));
    if (place_.learned) place_.learned(learned);
    learned.finish();
    seconds = loaded->about.wall_times["run"];
    if (rank_of(comm_) == 0 && !place_.quiet) {
      std::printf("going on at t = %s s from %s\n", brief(loaded->about.time).c_str(),
                  place_.checkpoint.c_str());
    }
    pace_.written(loaded->about.steps);
  }

  [[nodiscard]] CheckpointAbout about() const {
    return {resolved_text(scene_), simulation_.numbered().file_fingerprint, deciding_options()};
  }

  void write(double seconds) {
    CheckpointAbout now = about();
    now.wall_times = {{"run", seconds}};
    now.summary = summarise(comm_, simulation_, "running", {}).dump();
    Checkpoint checkpoint = checkpoint_of(comm_, simulation_, std::move(now));
    Archive learned({});
    if (place_.learned) place_.learned(learned);
    checkpoint["study"] = learned.columns();
    write_checkpoint(comm_, place_.checkpoint, checkpoint);
    simulation_.restore(std::move(checkpoint["state"]));
    pace_.written(simulation_.counts().steps);
  }

  MPI_Comm comm_;
  const Scene& scene_;
  const RunPlace& place_;
  Simulation& simulation_;
  CheckpointPace pace_;
};

}  // namespace

StudyRun run_in_study(MPI_Comm comm,
                      const Scene& scene,
                      const MeshFiles& meshes,
                      const RunPlace& place,
                      const Poll& poll,
                      const Inspect& inspect) {
  require_same_mesh(comm, scene, meshes);
  const auto start = Clock::now();
  double writing = 0;
  StudyRun run;
  try {
    Simulation simulation(comm, scene, false);
    StudyCheckpoint checkpoint(comm, scene, place, simulation);
    if (!place.checkpoint.empty()) checkpoint.go_on(run.seconds);
    while (!simulation.done() && !run.stopped) {
      simulation.step();
      if (inspect) inspect(simulation);
      run.stopped = checkpoint.stops(run, seconds_since(start), writing);
      poll(simulation.fraction());
    }
    if (!run.stopped) run.summary = summarise(comm, simulation, "completed", {});
  } catch (const Error& error) {
    if (error.code() != ExitCode::bad_input && error.code() != ExitCode::numerical) throw;
    const std::string unreadable = mesh_path(scene) + ": cannot be read";
    if (std::string(error.what()).starts_with(unreadable)) throw IoError(error.what());
    run.error = one_line(error.what());
    run.code = error.code();
  }
  run.seconds += seconds_since(start) - writing;
  require_same_mesh(comm, scene, meshes);
  return run;
}

std::string checkpoint_path(const std::string& folder, const std::string& id) {
  return folder + "/" + Checkpoints::folder_name + id + ".h5";
}

void forget_checkpoint(const std::string& folder, const std::string& id) {
  std::error_code none_there;
  std::filesystem::remove(checkpoint_path(folder, id), none_there);
}

void stop_study(MPI_Comm comm) {
  int signal = StatusFile::signal();
  MPI_Allreduce(MPI_IN_PLACE, &signal, 1, MPI_INT, MPI_MAX, comm);
  throw Stopped(signal, ::sigabbrev_np(signal));
}

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

}  // namespace stylet
