// What a run would take, from a few of its steps.
#pragma once

#include "stylet/scene/scene.hpp"
#include "stylet/simulation/run.hpp"

#include <mpi.h>

#include <string>

namespace stylet {

/// Measured on the first steps of a scene, on as many ranks as the run would have.
struct Timing {
  long long steps = 0;  ///< that were made
  double so_far = 0;    ///< s that they took, with the set-up and the first factor, without output
  double a_step = 0;    ///< s, of time.step; the mean of the later half
  double memory = 0;    ///< bytes, the most that all ranks together had
  bool whole = false;   ///< the scene was done
};

/// Collective. Makes steps for about `budget` s, at least a few, and writes nothing.
[[nodiscard]] Timing time_steps(MPI_Comm comm, const Scene& scene, double budget);

/// Collective. Lines of text: what would run, and where it would write; its time, memory and disk from
/// `time_steps`. Throws what the run would throw before its first step.
[[nodiscard]] std::string dry_run(MPI_Comm comm, const Scene& scene, const RunOptions& options);

}  // namespace stylet
