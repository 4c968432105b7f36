#include "stylet/needle/surface_crossings.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

// After Ericson, Real-Time Collision Detection, sec. 5.1.5.
ReferencePlace nearest_point(const SurfaceTriangle& triangle, ReferencePlace p) {
  const auto& [a, b, c] = triangle;
  const Vector3 ab = b - a;
  const Vector3 ac = c - a;
  const double d1 = dot(ab, p - a);
  const double d2 = dot(ac, p - a);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = dot(ab, p - b);
  const double d4 = dot(ac, p - b);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double d5 = dot(ab, p - c);
  const double d6 = dot(ac, p - c);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

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
