// Points of a unit cube: where a campaign samples its variables.
#pragma once

#include "stylet/study/campaign.hpp"

#include <cstdint>
#include <vector>

namespace stylet {

using UnitPoint = std::vector<double>;  ///< a coordinate in [0, 1] a variable

/// Levels of a Morris trajectory: 0, 1/3, 2/3, 1; a step is 2/3 (Morris 1991, p = 4).
inline constexpr int morris_levels = 4;

/// random, latin_hypercube: n points. morris: n trajectories of d + 1 points, one coordinate changed
/// at a time. sobol: Saltelli's scheme, n points of A, n of B, then for every variable n of A with
/// its column from B, the order of OpenTURNS' SobolIndicesExperiment. The same seed gives the same
/// points everywhere.
[[nodiscard]] std::vector<UnitPoint> sample(Design design, int n, std::size_t d, int seed);

}  // namespace stylet
