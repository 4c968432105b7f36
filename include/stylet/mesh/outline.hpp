// The outline of an inner region: an ellipse or a closed polygon (m).
#pragma once

#include "stylet/mesh/parameters.hpp"

#include <array>
#include <variant>
#include <vector>

namespace stylet {

using Outline = decltype(InnerRegion::outline);

[[nodiscard]] bool is_inside(const Outline& outline, ReferencePoint p);
/// The point of the outline nearest to p; on an ellipse to the last bits.
[[nodiscard]] ReferencePoint nearest_point(const Outline& outline, ReferencePoint p);
/// Enclosed area (m2).
[[nodiscard]] double enclosed_area(const Outline& outline);
/// Lower left and upper right corner of the smallest upright box around the outline.
[[nodiscard]] std::array<ReferencePoint, 2> bounding_box(const Outline& outline);

/// InputError that begins with `who` for an ellipse without extent and for a polygon with fewer
/// than three points, with two equal neighbours or that crosses itself.
void check_outline(const Outline& outline, const std::string& who);

/// The point of the segment from a to b nearest to p.
[[nodiscard]] ReferencePoint nearest_on_segment(ReferencePoint a,
                                                ReferencePoint b,
                                                ReferencePoint p);

}  // namespace stylet
