// Measures of a triangle and intersections with rays and segments. Points are counter-clockwise.
#pragma once

#include "stylet/geometry/points.hpp"

#include <array>
#include <optional>
#include <span>

namespace stylet {

template <class Frame>
double signed_area(Point<Frame> a, Point<Frame> b, Point<Frame> c) {
  return 0.5 * cross(b - a, c - a);
}

/// 4 sqrt(3) area / (sum of squared edges): 1 for the equilateral triangle, 0 for a degenerate
/// one, negative when inverted.
template <class Frame>
double quality(Point<Frame> a, Point<Frame> b, Point<Frame> c) {
  const double edges = dot(b - a, b - a) + dot(c - b, c - b) + dot(a - c, a - c);
  return edges > 0 ? 4 * std::sqrt(3.0) * signed_area(a, b, c) / edges : 0.0;
}

/// Barycentric coordinates of p in the triangle (sum 1; all non-negative inside).
template <class Frame>
std::array<double, 3> barycentric(Point<Frame> a, Point<Frame> b, Point<Frame> c, Point<Frame> p) {
  const double twice = cross(b - a, c - a);
  const double l0 = cross(b - p, c - p) / twice;
  const double l1 = cross(c - p, a - p) / twice;
  return {l0, l1, 1 - l0 - l1};
}

/// Where the ray origin + s direction (s > 0) meets the segment from a to b.
struct RayHit {
  double s;         ///< distance along the ray in units of |direction|
  double fraction;  ///< position on the segment, 0 at a and 1 at b
};

template <class Frame>
std::optional<RayHit> ray_segment(Point<Frame> origin,
                                  Vector2 direction,
                                  Point<Frame> a,
                                  Point<Frame> b) {
  const Vector2 edge = b - a;
  const double det = cross(direction, edge);
  if (det == 0) return std::nullopt;
  const Vector2 from = a - origin;
  return RayHit{cross(from, edge) / det, cross(from, direction) / det};
}

/// True if p is inside the closed polygon (even-odd rule).
template <class Frame>
bool inside_polygon(std::span<const Point<Frame>> polygon, Point<Frame> p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const auto& a = polygon[i];
    const auto& b = polygon[j];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) {
      inside = !inside;
    }
  }
  return inside;
}

}  // namespace stylet
