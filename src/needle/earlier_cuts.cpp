#include "stylet/needle/earlier_cuts.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

namespace {

struct Interval {
  double from;
  double to;
};

// Part of the ray within `radius` of the segment from a to b; at an open end also beyond b, by the
// radius, so that a path that bends leaves no wedge between its segments.
Interval within(ReferencePoint p,
                Vector2 r,
                ReferencePoint a,
                ReferencePoint b,
                double before,
                double after,
                double radius) {
  const double length = distance(a, b);
  const Vector2 along = (1 / length) * (b - a);
  Interval part{-radius, 1e300};
  // from + s slope in [low, high]
  const auto clip = [&](double from, double slope, double low, double high) {
    if (slope == 0) {
      if (from < low || from > high) part.to = part.from;
      return;
    }
    const double s0 = (low - from) / slope;
    const double s1 = (high - from) / slope;
    part.from = std::max(part.from, std::min(s0, s1));
    part.to = std::min(part.to, std::max(s0, s1));
  };
  clip(dot(p - a, along), dot(r, along), -before, length + after);
  clip(cross(along, p - a), cross(along, r), -radius, radius);
  return part;
}

}  // namespace

double EarlierCuts::free_length(ReferencePoint p, Vector2 r, double radius) const {
  std::vector<Interval> parts;
  for (const auto& path : paths) {
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      if (path[i] == path[i + 1]) continue;
      const bool first = i == 0;
      const bool last = i + 2 == path.size();
      parts.push_back(
          within(p, r, path[i], path[i + 1], first ? 0 : radius, last ? 0 : radius, radius));
    }
  }
  std::ranges::sort(parts, {}, &Interval::from);
  double end = 0;
  for (const auto& [from, to] : parts) {
    const double slack = 1e-9 * radius;  // a tip that stands at the skin or at the end of a segment
    if (from <= end + slack) end = std::max(end, to);
  }
  return end;
}

bool is_near(std::span<const ReferencePoint> points, ReferencePoint p, double radius) {
  return std::ranges::any_of(points, [&](ReferencePoint q) { return distance(p, q) <= radius; });
}

}  // namespace stylet
