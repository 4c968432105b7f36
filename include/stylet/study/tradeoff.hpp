// Speed against accuracy: methods, meshes, steps and kernels of one scene, their error and their time.
//
// A needle in space is split by a kernel, whose own error no mesh shows: it goes with the radius squared
// (converge.hpp). So the reference has a narrower kernel beside the scene's, each run is compared with the one of
// its kernel, and what that kernel itself is off by, as those two tell, is added.
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
  bool is_element = false;  ///< the usual way, or it with another element
};

struct TradeoffRun {
  std::string way;
  int refine = 0;
  double step = 0;    ///< s, as asked for
  double kernel = 1;  ///< of needles in space: kernel_radius over the scene's
  double value = 0;   ///< m, placement error
  double error = 0;  ///< m, of the value against the reference of its kernel, with the kernel's own
  /// m; the largest error of this and all finer runs of this way and kernel. Errors of mesh and step may
  /// cancel at one level; only this one can be relied on.
  double safe_error = 0;
  double seconds = 0;  ///< median wall time
  std::string failure;
  bool on_front = false;  ///< nothing faster has as small a safe error
};

struct Tradeoff {
  std::string folder;
  double reference = 0;     ///< m
  double kernel_error = 0;  ///< m; of the scene's kernel
  std::vector<TradeoffRun> runs;
};

constexpr const char* reference_way = "reference";
/// The way of a finest run, which the others are compared with.
[[nodiscard]] inline bool is_reference(const TradeoffRun& run) {
  return run.way == reference_way;
}

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
