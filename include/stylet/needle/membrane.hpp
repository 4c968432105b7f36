// The membrane: a closed polygon fixed in the reference frame (paper, sec. V.C).
#pragma once

#include "stylet/geometry/points.hpp"

#include <optional>
#include <span>
#include <vector>

namespace stylet {

/// Distance (m) to the nearest point where the segment from p along the unit vector r, of the given
/// length, crosses the polygon, but for those within `radius` of a puncture.
[[nodiscard]] std::optional<double> first_crossing(std::span<const ReferencePoint> polygon,
                                                   ReferencePoint p,
                                                   Vector2 r,
                                                   double length,
                                                   std::span<const ReferencePlace> punctures,
                                                   double radius);

}  // namespace stylet
