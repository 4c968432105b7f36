// What a reader of a run's numbers has to know and cannot see in them.
#pragma once

#include "stylet/simulation/simulation.hpp"

#include <string>
#include <vector>

namespace stylet {

/// Collective once the run is done. Each names what is affected, where and by how much; a run without a
/// reason for doubt has none.
[[nodiscard]] std::vector<std::string> notes_of(const Simulation& simulation);

/// How far a needle under a hand should go in a step at most (m): its tip_length, or for a point tip the
/// length of an element.
[[nodiscard]] double longest_way(const Mesh& mesh, const NeedleParameters& needle);

}  // namespace stylet
