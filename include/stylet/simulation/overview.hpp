// What a scene is, as its mesh makes it: for a look before the run.
#pragma once

#include "stylet/simulation/simulation.hpp"

#include <string>

namespace stylet {

/// Lines of text, aligned. Regions, curves, loads, membrane, needles with their way and stops, steps,
/// and an estimate of memory, disk and time. n_ranks: of the run.
[[nodiscard]] std::string overview(const Simulation& simulation, int n_ranks);

}  // namespace stylet
