#include "stylet/needle/membrane.hpp"

#include "stylet/geometry/triangle.hpp"
#include "stylet/needle/earlier_cuts.hpp"

#include <algorithm>

namespace stylet {

std::optional<double> first_crossing(std::span<const ReferencePoint> polygon,
                                     ReferencePoint p,
                                     Vector2 r,
                                     double length,
                                     std::span<const ReferencePlace> punctures,
                                     double radius) {
  std::optional<double> first;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto& a = polygon[i];
    const auto& b = polygon[(i + 1) % polygon.size()];
    const auto hit = ray_segment(p, r, a, b);
    // A vertex belongs to both of its edges: a crossing there must not slip through, nor one of a tip
    // that stands on the membrane.
    constexpr double end = 1e-12;
    constexpr double behind = 1e-9;
    if (!hit || hit->fraction < -end || hit->fraction > 1 + end) continue;
    if (hit->s < -behind * distance(a, b) || hit->s > length) continue;
    const double s = std::max(0.0, hit->s);
    if (is_near(punctures, p + s * r, radius)) continue;
    if (!first || s < *first) first = s;
  }
  return first;
}

}  // namespace stylet
