#include "stylet/simulation/strain.hpp"

#include "stylet/fem/element.hpp"
#include "stylet/geometry/triangle.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace stylet {

namespace {

double largest_principal_strain(const Mesh& mesh, int c, std::span<const double> u) {
  const auto nodes = mesh.cell(c);
  std::array<LinearSimplex<2>::Vector, 3> corners{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto at = 2 * static_cast<std::size_t>(nodes[k]);
    corners[k] = {u[at], u[at + 1]};
  }
  const LinearSimplex<2> element(
      {mesh.coordinates(nodes[0]), mesh.coordinates(nodes[1]), mesh.coordinates(nodes[2])});
  const auto h = element.displacement_gradient(corners);
  const double mean = 0.5 * (h[0][0] + h[1][1]);
  const double radius = std::hypot(0.5 * (h[0][0] - h[1][1]), 0.5 * (h[0][1] + h[1][0]));
  return std::abs(mean) + radius;
}

ReferencePoint centre_of(const Mesh& mesh, int c) {
  const auto n = mesh.cell(c);
  const auto a = mesh.point(n[0]);
  return a + (1.0 / 3) * ((mesh.point(n[1]) - a) + (mesh.point(n[2]) - a));
}

/// The needle's path: cells with a node of it, and all whose centre is within the reach.
class Zone {
 public:
  Zone(const Mesh& mesh, const Track* track, double reach) : reach_(reach) {
    if (track == nullptr) return;
    for (const ShaftNode& shaft : track->nodes()) {
      points_.push_back(mesh.point(shaft.node));
      for (const int c : mesh.cells_around(shaft.node)) cells_.push_back(c);
    }
    std::ranges::sort(cells_);
  }
  [[nodiscard]] bool holds(int c, ReferencePoint centre) const {
    if (std::ranges::binary_search(cells_, c)) return true;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const ReferencePoint b = points_[std::min(i + 1, points_.size() - 1)];
      if (distance(nearest(points_[i], b, centre), centre) < reach_) return true;
    }
    return false;
  }

 private:
  static ReferencePoint nearest(ReferencePoint a, ReferencePoint b, ReferencePoint p) {
    const Vector2 edge = b - a;
    const double squared = dot(edge, edge);
    const double s = squared > 0 ? std::clamp(dot(p - a, edge) / squared, 0.0, 1.0) : 0.0;
    return a + s * edge;
  }

  double reach_;
  std::vector<ReferencePoint> points_;
  std::vector<int> cells_;
};

}  // namespace

void TurnedOver::add(const Mesh& mesh, int cell) {
  if (triangles++ == 0) place = centre_of(mesh, cell);
  area += mesh.cell_measure(cell);
}

bool is_turned_over(const Mesh& mesh, int cell, const std::array<Vector2, 3>& displacements) {
  const auto nodes = mesh.cell(cell);
  const auto x = [&](std::size_t k) { return displaced(mesh.point(nodes[k]), displacements[k]); };
  return signed_area(x(0), x(1), x(2)) <= 0;
}

TurnedOver turned_over(const Mesh& mesh, std::span<const double> u, double time) {
  TurnedOver all;
  all.time = time;
  std::vector<WorldPoint> x;
  x.reserve(static_cast<std::size_t>(mesh.n_nodes()));
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const auto at = 2 * static_cast<std::size_t>(node);
    x.push_back(displaced(mesh.point(node), {u[at], u[at + 1]}));
  }
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto nodes = mesh.cell(c);
    const auto corner = [&](std::size_t k) { return x[static_cast<std::size_t>(nodes[k])]; };
    if (signed_area(corner(0), corner(1), corner(2)) <= 0) all.add(mesh, c);
  }
  return all;
}

void raise(LargestStrain& largest,
           const Mesh& mesh,
           std::span<const double> u,
           double time,
           const Track* track,
           double tip_length) {
  constexpr double share = 1e-3;
  const Zone zone(mesh, track, tip_length);
  struct Strained {
    double strain;
    double area;
    ReferencePoint centre;
  };
  std::vector<Strained> candidates;
  double area = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    area += mesh.cell_measure(c);
    const double strain = largest_principal_strain(mesh, c, u);
    if (!(strain > largest.widespread.value)) continue;
    const ReferencePoint centre = centre_of(mesh, c);
    if (strain > largest.anywhere.value) largest.anywhere = {strain, time, centre};
    if (!zone.holds(c, centre)) candidates.push_back({strain, mesh.cell_measure(c), centre});
  }
  std::ranges::sort(candidates, std::greater(), &Strained::strain);
  double exceeded_on = 0;
  for (const Strained& cell : candidates) {
    exceeded_on += cell.area;
    if (exceeded_on < share * area) continue;
    largest.widespread = {cell.strain, time, cell.centre};
    return;
  }
}

}  // namespace stylet
