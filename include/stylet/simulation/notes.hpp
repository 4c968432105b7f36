// What a reader of a run's numbers has to know and cannot see in them.
#pragma once

#include "stylet/simulation/simulation.hpp"

#include <string>
#include <vector>

namespace stylet {

/// Collective once the run is done. Each names what is affected, where and by how much; a run without a
/// reason for doubt has none.
[[nodiscard]] std::vector<std::string> notes_of(const Simulation& simulation);

}  // namespace stylet
