// What a run writes so that it can go on: whole states in checkpoints/ of its folder.
#pragma once

#include "stylet/output/checkpoint_file.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/simulation/recorder.hpp"
#include "stylet/simulation/simulation.hpp"

#include <mpi.h>

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

/// Of a run as a whole.
struct CheckpointAbout {
  std::string scene;                      ///< its resolved text
  std::string mesh;                       ///< fingerprint of its mesh file; empty without
  std::vector<std::string> options = {};  ///< of PETSc, which are given anew on --resume
  std::string program = {};
  std::string written = {};  ///< when, UTC
  int n_ranks = 0;
  double time = 0;  ///< s
  long long steps = 0;
  std::string phase = {};                         ///< of the needle that is in; empty without one
  Vector3 tip = {};                               ///< of it, in space (m)
  std::string summary = {};                       ///< of the run so far, JSON
  std::map<std::string, double> wall_times = {};  ///< s, by phase
  void archive(Archive& archive);
};

/// A checkpoint as it was read.
struct LoadedCheckpoint {
  std::string path;
  CheckpointAbout about;
  std::optional<RecorderPlace> place;  ///< of a run's files; none of a run of a study
  Archive::Columns state;
  Archive::Columns study;  ///< what a study has learned in the run
};

/// When checkpoints are due.
class CheckpointPace {
 public:
  explicit CheckpointPace(CheckpointParameters parameters) : parameters_(parameters) {}
  /// Not collective. By this rank's clock, or the steps made.
  [[nodiscard]] bool due(long long steps) const;
  void written(long long steps);

 private:
  CheckpointParameters parameters_;
  long long last_steps_ = 0;
  std::chrono::steady_clock::time_point last_time_ = std::chrono::steady_clock::now();
};

/// Collective, between steps. What is known of a run and its state; the fields of `about` that these tell
/// are filled in.
[[nodiscard]] Checkpoint checkpoint_of(MPI_Comm comm,
                                       Simulation& simulation,
                                       CheckpointAbout about);

class Checkpoints {
 public:
  static constexpr const char* folder_name = "checkpoints/";

  /// The folder is lent.
  Checkpoints(MPI_Comm comm, OutputFolder& folder, const OutputParameters& output);

  /// Not collective. By this rank's clock, or the steps made.
  [[nodiscard]] bool due(long long steps) const;
  /// Collective. Files of the run first, then the state; what is older than those to keep goes. The
  /// simulation that goes on is then alike to one that is resumed.
  void write(Simulation& simulation, Recorder& recorder, CheckpointAbout about, bool goes_on);
  /// Collective. The newest whole one, if there is any. Those that are not whole are removed, and told.
  [[nodiscard]] std::optional<LoadedCheckpoint> newest(std::vector<std::string>& notes);

 private:
  void require_own() const;
  [[nodiscard]] std::vector<std::string> files() const;
  void remove(const std::string& path) const;

  MPI_Comm comm_;
  OutputFolder& output_;
  std::string folder_;
  bool added_ = false;  ///< to the output folder
  std::optional<CheckpointPace> pace_;
  int keep_;
};

/// Collective. None, and why, if it is not whole. Throws InputError, IoError.
[[nodiscard]] std::optional<LoadedCheckpoint> load_checkpoint(MPI_Comm comm,
                                                              const std::string& path,
                                                              std::string& fault);

inline constexpr const char* allowed_on_resume =
    "allowed on --resume: other output, image, expect, time.until and time.duration; begin anew "
    "with --force";

/// Throws InputError that names the first key in which this scene is another one than the one stored,
/// unless it decides about output and end only, and says what is allowed; or the mesh file, or options of
/// solvers.
void require_same_physics(const CheckpointAbout& stored,
                          const std::string& path,
                          const Scene& scene,
                          const CheckpointAbout& now,
                          const std::string& allowed = allowed_on_resume);

/// Throws InputError where the state is of another moment than the checkpoint says.
void require_at(const Simulation& simulation, const LoadedCheckpoint& stored);

/// Throws InputError where files of the run would begin or end on its way.
void require_same_files(const LoadedCheckpoint& stored, const Scene& scene);

}  // namespace stylet
