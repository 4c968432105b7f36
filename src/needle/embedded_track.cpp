#include "stylet/needle/embedded_track.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/mesh/embedded_point.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace stylet {

namespace {

// Of the kernel, that has to lie in the tissue: with less the needle hardly touches it.
constexpr double least_inside = 0.25;
// Of a segment: a start that is no deeper lies on the skin.
constexpr double on_skin = 1e-3;
// Two stations on (0, 1).
constexpr std::array<double, 2> gauss{0.2113248654051871, 0.7886751345948129};

std::string text_of(Vector3 v) {
  return "(" + ten_digits(v.x) + ", " + ten_digits(v.y) + ", " + ten_digits(v.z) + ")";
}

std::string in_mm(ReferencePlace x) {
  return text_of(1e3 * (x - ReferencePlace{})) + " mm";
}

Vector3 unit(Vector3 v) {
  return 1 / norm(v) * v;
}

/// The direction, and two across: the first one in the plane of the axis that is least along it.
std::array<Vector3, 3> axes_of(Vector3 direction) {
  const Vector3 along = unit(direction);
  Vector3 least{1, 0, 0};
  for (const Vector3 axis : {Vector3{0, 1, 0}, {0, 0, 1}}) {
    if (std::abs(dot(axis, along)) < std::abs(dot(least, along))) least = axis;
  }
  const Vector3 across = unit(least - dot(least, along) * along);
  return {along, across, cross(along, across)};
}

std::vector<TrackSegment> cut(double depth, double length) {
  const int n = std::max(1, static_cast<int>(std::lround(depth / length)));
  std::vector<TrackSegment> segments;
  for (int i = 0; i < n; ++i) {
    segments.push_back({i * length, i + 1 == n ? depth : (i + 1) * length, 0, 0});
  }
  return segments;
}

TrackSegment covered_part(TrackSegment segment, double from, double to) {
  segment.from = std::max(segment.from, from);
  segment.to = std::min(segment.to, to);
  return segment;
}

double mean_edge(const Mesh& mesh) {
  double sum = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto t = mesh.tetrahedron(c);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) sum += distance(t[i], t[j]);
    }
  }
  return sum / (6.0 * mesh.n_cells());
}

Stretch way(
    const Mesh& mesh, ReferencePlace start, Vector3 direction, double depth, double segment) {
  if (locate(mesh, start + -on_skin * segment * direction)) {
    throw InputError("a needle at " + in_mm(start) + " in direction " + text_of(direction) +
                     " begins inside the tissue: it has to begin on the skin, or before it");
  }
  auto stretch = first_stretch(mesh, start, direction);
  if (!stretch) {
    throw InputError("a needle at " + in_mm(start) + " in direction " + text_of(direction) +
                     " misses the tissue");
  }
  stretch->to = std::min(stretch->to, stretch->from + depth);
  return *stretch;
}

CellGrid grid_around(
    const Mesh& mesh, ReferencePlace a, ReferencePlace b, double radius, double edge) {
  const Vector3 margin{radius, radius, radius};
  const ReferencePlace low{std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
  const ReferencePlace high{std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
  return {mesh, low + -margin, high + margin, edge};
}

}  // namespace

std::pair<Vector3, Vector3> across_of(Vector3 direction) {
  const auto axes = axes_of(direction);
  return {axes[1], axes[2]};
}

EmbeddedTrack::EmbeddedTrack(const Mesh& mesh,
                             ReferencePlace start,
                             Vector3 direction,
                             double depth,
                             const TrackLayout& layout,
                             const std::vector<RegionModuli>& regions)
    : EmbeddedTrack(mesh,
                    start,
                    axes_of(direction),
                    way(mesh, start, unit(direction), depth, layout.segment),
                    layout,
                    regions) {}

EmbeddedTrack::EmbeddedTrack(const Mesh& mesh,
                             ReferencePlace start,
                             const std::array<Vector3, 3>& axes,
                             const Stretch& stretch,
                             const TrackLayout& layout,
                             const std::vector<RegionModuli>& regions)
    : skin_(start + stretch.from * axes[0]),
      axes_(axes),
      segments_(cut(stretch.to - stretch.from, layout.segment)),
      rest_(layout.radius,
            kernel_rings(layout.kernel_radius, layout.radius, layout.rings),
            segments_.back().to,
            layout.below_skin) {
  const auto rings = kernel_rings(layout.kernel_radius, layout.radius, layout.rings);
  const double edge = mean_edge(mesh);
  const CellGrid grid =
      grid_around(mesh, skin_, at(segments_.back().to), rings.back().radius, edge);
  for (TrackSegment& segment : segments_) {
    const auto middle = grid.find(at((segment.from + segment.to) / 2));
    const int cell = middle ? middle->cell : stretch.cell;
    cells_.push_back(cell);
    const auto& moduli = regions[static_cast<std::size_t>(mesh.region(cell))];
    segment.shear_modulus = moduli.shear_modulus;
    segment.poisson_ratio = moduli.poisson_ratio;
    shares_.push_back(mean_over(mesh, grid, segment, rings, edge / 2));
  }
  for (const TrackSegment& a : segments_) {
    for (const TrackSegment& b : segments_) {
      rest_along_.push_back(rest_.along(a, b));
      rest_across_.push_back(rest_.across(a, b));
    }
  }
}

std::vector<EmbeddedTrack::NodeShare> EmbeddedTrack::mean_over(const Mesh& mesh,
                                                               const CellGrid& grid,
                                                               const TrackSegment& segment,
                                                               std::span<const Ring> rings,
                                                               double spacing) const {
  std::map<int, double> of_node;
  double inside = 0;
  for (const double station : gauss) {
    const ReferencePlace centre = at(segment.from + station * segment.length());
    for (const Ring& ring : rings) {
      const double around = 2 * std::numbers::pi;
      const int n = std::max(6, static_cast<int>(std::ceil(around * ring.radius / spacing)));
      const double weight = ring.weight / (2 * n);
      for (int i = 0; i < n; ++i) {
        const double angle = around * i / n;
        const auto x = centre + ring.radius * std::cos(angle) * axes_[1] +
                       ring.radius * std::sin(angle) * axes_[2];
        const auto found = grid.find(x);
        if (!found) continue;
        inside += weight;
        for (const auto& [node, share] : node_weights(mesh, *found)) {
          of_node[node] += weight * share;
        }
      }
    }
  }
  if (inside < least_inside) {
    throw InputError(
        "the kernel of a needle lies outside the tissue by more than three quarters at " +
        in_mm(at(segment.from)) + ": kernel_radius has to be smaller there");
  }
  std::vector<NodeShare> shares;
  for (const auto& [node, share] : of_node) shares.push_back({node, share / inside});
  return shares;
}

SparseRow EmbeddedTrack::row(TrackPlace place) const {
  const Vector3 axis = direction(place.component);
  SparseRow row;
  for (const auto& [node, share] : shares_[static_cast<std::size_t>(place.point)]) {
    row.push_back({3 * node, share * axis.x});
    row.push_back({3 * node + 1, share * axis.y});
    row.push_back({3 * node + 2, share * axis.z});
  }
  return row;
}

double EmbeddedTrack::rest(TrackPlace a, TrackPlace b) const {
  if (a.component != b.component) return 0;
  const auto& entries = a.component == Component::along ? rest_along_ : rest_across_;
  return entries[static_cast<std::size_t>(a.point) * segments_.size() +
                 static_cast<std::size_t>(b.point)];
}

std::vector<PointShare> EmbeddedTrack::shares(double from, double to) const {
  std::vector<PointShare> shares;
  for (int i = 0; i < size(); ++i) {
    const double covered = covered_part(segment(i), from, to).length();
    if (covered > 0) shares.push_back({i, covered / (to - from)});
  }
  return shares;
}

double EmbeddedTrack::rest_of_ends(double from, double to) const {
  const auto parts = shares(from, to);
  double sum = 0;
  for (const auto& [i, share] : parts) {
    const TrackSegment part = covered_part(segment(i), from, to);
    const bool whole = part.length() == segment(i).length();
    for (const auto& [j, other_share] : parts) {
      const TrackSegment other = covered_part(segment(j), from, to);
      if (whole && other.length() == segment(j).length()) continue;
      sum += share * other_share *
             (rest_.along(part, other) - rest({i, Component::along}, {j, Component::along}));
    }
  }
  return sum;
}

}  // namespace stylet
