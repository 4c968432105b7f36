#include "stylet/needle/membrane.hpp"

#include "stylet/geometry/triangle.hpp"

namespace stylet {

std::optional<MembraneCrossing> first_crossing(std::span<const ReferencePoint> polygon,
                                               ReferencePoint p,
                                               Vector2 r,
                                               double length,
                                               const std::set<int>& punctured) {
  std::optional<MembraneCrossing> first;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto& a = polygon[i];
    const auto& b = polygon[(i + 1) % polygon.size()];
    const auto hit = ray_segment(p, r, a, b);
    // A vertex belongs to both of its edges: a crossing there must not slip through.
    constexpr double end = 1e-12;
    if (!hit || hit->fraction < -end || hit->fraction > 1 + end) continue;
    if (hit->s < 0 || hit->s > length || punctured.contains(static_cast<int>(i))) continue;
    if (!first || hit->s < first->distance) {
      first = MembraneCrossing{hit->s, static_cast<int>(i)};
    }
  }
  return first;
}

}  // namespace stylet
