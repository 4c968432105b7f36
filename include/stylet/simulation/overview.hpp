// What a scene is, as its mesh makes it: for a look before the run.
#pragma once

#include "stylet/simulation/dry_run.hpp"
#include "stylet/simulation/simulation.hpp"

#include <string>

namespace stylet {

/// Lines of text, aligned. Regions, curves, loads, membrane, needles with their way and stops, steps,
/// and an estimate of memory, disk and time. n_ranks: of the run. measured: what the estimate is made from;
/// none: what is usual.
[[nodiscard]] std::string overview(const Simulation& simulation,
                                   int n_ranks,
                                   const Timing* measured = nullptr);

}  // namespace stylet
