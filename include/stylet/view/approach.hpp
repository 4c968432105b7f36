// The way of a needle that is about to enter at a height.
#pragma once

#include "stylet/needle/parameters.hpp"
#include "stylet/simulation/simulation.hpp"

#include <string>

namespace stylet {

struct Approach {
  double skin = 0;       ///< where the undeformed tissue begins on it (m, along)
  double deepest = 0;    ///< how far a tip may go (m, along)
  std::string obstacle;  ///< why no needle may enter there; empty: one may
};

/// Of a needle like this one at its height, in the mesh as it is now.
[[nodiscard]] Approach approach_of(const Simulation& simulation, NeedleParameters needle);

}  // namespace stylet
