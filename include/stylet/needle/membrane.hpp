// The membrane: a closed polygon fixed in the reference frame (paper, sec. V.C).
#pragma once

#include "stylet/geometry/points.hpp"

#include <optional>
#include <set>
#include <span>
#include <vector>

namespace stylet {

struct MembraneCrossing {
  double distance;  ///< along the ray (m)
  int edge;         ///< from vertex `edge` to the next
};

/// The nearest edge that the segment from p along the unit vector r, of the given length, crosses,
/// without the edges already punctured by this needle.
[[nodiscard]] std::optional<MembraneCrossing> first_crossing(
    std::span<const ReferencePoint> polygon,
    ReferencePoint p,
    Vector2 r,
    double length,
    const std::set<int>& punctured);

}  // namespace stylet
