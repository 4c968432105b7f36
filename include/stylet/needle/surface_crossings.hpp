// Where a straight line goes through a surface of triangles: a membrane in space.
#pragma once

#include "stylet/geometry/points.hpp"

#include <array>
#include <span>
#include <vector>

namespace stylet {

using SurfaceTriangle = std::array<ReferencePlace, 3>;

/// Of a triangle, to p.
[[nodiscard]] ReferencePlace nearest_point(const SurfaceTriangle& triangle, ReferencePlace p);

/// Distances (m) from p along the unit vector r, ascending, 0 to `length`. A line through an edge meets the
/// triangles on both sides of it, so that none is missed (after Woop, Benthin and Wald, JCGT 2 (2013) 65).
[[nodiscard]] std::vector<double> surface_crossings(std::span<const SurfaceTriangle> surface,
                                                    ReferencePlace p,
                                                    Vector3 r,
                                                    double length);

}  // namespace stylet
