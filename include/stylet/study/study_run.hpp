// One run of a study: a scene without files of its own, whose failure is a result.
#pragma once

#include "stylet/base/errors.hpp"
#include "stylet/simulation/simulation.hpp"
#include "stylet/study/identity.hpp"
#include "stylet/study/pool.hpp"

#include <nlohmann/json.hpp>

#include <functional>
#include <string>

namespace stylet {

struct StudyRun {
  std::string error;               ///< empty: it came to its end
  ExitCode code = ExitCode::done;  ///< of the error
  double seconds = 0;              ///< wall time, set-up included, checkpoints left out
  nlohmann::ordered_json summary;  ///< as summary.json; empty after an error
  bool stopped = false;            ///< by a signal; its state is in its place
};

/// Where the state of a run is kept while it goes on: every ten minutes, as the scene's output.checkpoint
/// says, and when a signal stops it.
struct RunPlace {
  std::string
      checkpoint;      ///< path of the file; a study resumed finds it there, of the same run only
  bool quiet = false;  ///< else it says where it goes on
  /// What the study has learned in the run so far.
  std::function<void(Archive&)> learned = {};
};

using Inspect = std::function<void(const Simulation&)>;

/// Collective. A scene that does not fit its mesh and a step without a valid answer become `error`;
/// everything else throws, a mesh file that is no longer the study's too: no result of a scene.
/// inspect: collective, after every step. The checkpoint stays when the run has ended: until its result
/// is on the disk.
[[nodiscard]] StudyRun run_in_study(MPI_Comm comm,
                                    const Scene& scene,
                                    const MeshFiles& meshes,
                                    const RunPlace& place,
                                    const Poll& poll,
                                    const Inspect& inspect = {});

/// Of the run of that number in a study's folder.
[[nodiscard]] std::string checkpoint_path(const std::string& folder, const std::string& id);
/// Not collective. The run's result is on the disk.
void forget_checkpoint(const std::string& folder, const std::string& id);

/// Collective. Throws Stopped, by the signal that any rank has had.
[[noreturn]] void stop_study(MPI_Comm comm);

/// Shown and stored as one line.
[[nodiscard]] std::string one_line(std::string text);

}  // namespace stylet
