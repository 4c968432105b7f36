#include "stylet/needle/surface_crossings.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

std::vector<double> surface_crossings(std::span<const SurfaceTriangle> surface,
                                      ReferencePlace p,
                                      Vector3 r,
                                      double length) {
  // Seen along the line every corner is a point of the plane across it. The sides of an edge then have
  // opposite signs to the last bit, whichever triangle asks.
  Vector3 least{1, 0, 0};
  for (const Vector3 axis : {Vector3{0, 1, 0}, {0, 0, 1}}) {
    if (std::abs(dot(axis, r)) < std::abs(dot(least, r))) least = axis;
  }
  const Vector3 e = cross(r, least);
  const Vector3 f = cross(r, e);
  struct Seen {
    Vector2 at;
    double depth;
  };
  const auto seen = [&](ReferencePlace x) {
    const Vector3 from = x - p;
    return Seen{{dot(e, from), dot(f, from)}, dot(r, from)};
  };
  std::vector<double> found;
  for (const auto& [a, b, c] : surface) {
    const Seen corner[3] = {seen(a), seen(b), seen(c)};
    double side[3];
    for (std::size_t i = 0; i < 3; ++i) {
      side[i] = stylet::cross(corner[(i + 1) % 3].at, corner[(i + 2) % 3].at);
    }
    const bool inside = std::ranges::all_of(side, [](double s) { return s >= 0; }) ||
                        std::ranges::all_of(side, [](double s) { return s <= 0; });
    const double sum = side[0] + side[1] + side[2];
    if (!inside || sum == 0) continue;
    double depth = 0;
    for (std::size_t i = 0; i < 3; ++i) depth += side[i] / sum * corner[i].depth;
    if (depth >= 0 && depth <= length) found.push_back(depth);
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace stylet
