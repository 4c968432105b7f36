// Speed against accuracy: methods, meshes and steps of one scene, their error and their time.
#pragma once

#include "stylet/study/study_folder.hpp"

#include <mpi.h>

#include <string>
#include <vector>

namespace stylet {

struct TradeoffOptions {
  StudyOptions study;
  int mesh_levels = 2;  ///< the scene's mesh and finer ones; the reference is one finer still
  int step_levels = 3;  ///< the scene's step, and steps 2, 4 ... times as long
  int repeats = 3;      ///< of a run, for its median time; runs above 10 s are not repeated
};

/// A way to compute the scene, and the changes of the scene that make it.
struct Way {
  std::string name;
  std::vector<std::string> changes;
};

struct TradeoffRun {
  std::string way;
  int refine = 0;
  double step = 0;   ///< s, as asked for
  double value = 0;  ///< m, placement error
  double error = 0;  ///< m, of the value against the reference
  /// m; the largest error of this and all finer runs of this way. Errors of mesh and step may cancel
  /// at one level; only this one can be relied on.
  double safe_error = 0;
  double seconds = 0;  ///< median wall time
  std::string failure;
  bool on_front = false;  ///< nothing faster has as small a safe error
};

struct Tradeoff {
  std::string folder;
  double reference = 0;  ///< m
  std::vector<TradeoffRun> runs;
};

// The way that all others are measured against, and the one without inertia.
constexpr const char* usual_way = "backward_euler";
constexpr const char* slow_limit_way = "quasi_static";

/// Collective. tradeoff.json, and the front on rank 0's standard output.
void report(MPI_Comm comm, const Tradeoff& result, bool quiet);

/// Collective. One run at a time on all ranks. scene_file, text and changes: as for load_scene. Writes
/// results.csv, tradeoff.json and scenes/, prints the front and draws. A way that a scene refuses,
/// such as explicit steps with stiffness damping, is a row with the reason.
Tradeoff tradeoff(MPI_Comm comm,
                  const std::string& scene_file,
                  const std::string& text,
                  const std::vector<std::string>& changes,
                  const TradeoffOptions& options);

}  // namespace stylet
