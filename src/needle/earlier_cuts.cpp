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
Interval within(ReferencePlace p,
                Vector3 r,
                ReferencePlace a,
                ReferencePlace b,
                double before,
                double after,
                double radius) {
  constexpr Interval none{0, -1};
  const double length = distance(a, b);
  const Vector3 along = (1 / length) * (b - a);
  Interval part{-radius, 1e300};
  const auto clip = [&](double s0, double s1) {
    part.from = std::max(part.from, std::min(s0, s1));
    part.to = std::min(part.to, std::max(s0, s1));
  };
  // Beside the segment.
  const double from = dot(p - a, along);
  const double slope = dot(r, along);
  if (slope != 0) {
    clip((-before - from) / slope, (length + after - from) / slope);
  } else if (from < -before || from > length + after) {
    return none;
  }
  // Within the cylinder around it.
  const Vector3 aside = p - a - from * along;
  const Vector3 drift = r - slope * along;
  const double square = dot(drift, drift);
  const double middle = dot(aside, drift);
  const double room = radius * radius - dot(aside, aside);
  const double root = middle * middle + square * room;
  if (root < 0 || (square == 0 && room < 0)) return none;
  if (square > 0) {
    clip((-middle - std::sqrt(root)) / square, (-middle + std::sqrt(root)) / square);
  }
  return part;
}

}  // namespace

double EarlierCuts::free_length(ReferencePlace p, Vector3 r, double radius) const {
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

bool is_near(std::span<const ReferencePlace> points, ReferencePlace p, double radius) {
  return std::ranges::any_of(points, [&](ReferencePlace q) { return distance(p, q) <= radius; });
}

}  // namespace stylet
