#include "stylet/mesh/embedded_point.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/geometry/triangle.hpp"

#include <algorithm>
#include <limits>

namespace stylet {

namespace {

// A point on an edge is inside both of its cells, up to round-off of the barycentric coordinates.
constexpr double on_edge = 1e-9;
// Of the mesh's extent: what is left of a coordinate with eight digits, or turned by an angle that has
// them, on the wrong side of the boundary.
constexpr double on_boundary = 1e-8;

std::array<double, 3> weights_in(const Mesh& mesh, int c, ReferencePoint x) {
  const auto nodes = mesh.cell(c);
  return barycentric(mesh.point(nodes[0]), mesh.point(nodes[1]), mesh.point(nodes[2]), x);
}

/// How far inside a cell, as the least distance from the lines along its edges; negative outside.
double depth_in(const Mesh& mesh, int c, const std::array<double, 3>& weights) {
  const auto n = mesh.cell(c);
  double depth = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const double base = distance(mesh.point(n[(i + 1) % 3]), mesh.point(n[(i + 2) % 3]));
    depth = std::min(depth, weights[i] * 2 * mesh.cell_measure(c) / base);
  }
  return depth;
}

double extent_of(const Mesh& mesh) {
  double extent = 0;
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    extent = std::max(extent, distance(mesh.point(0), mesh.point(node)));
  }
  return extent;
}

}  // namespace

std::optional<EmbeddedPoint> locate(const Mesh& mesh, ReferencePoint x, int hint) {
  int c = hint;
  for (int steps = 0; steps < mesh.n_cells(); ++steps) {
    const auto weights = weights_in(mesh, c, x);
    const auto lowest =
        static_cast<std::size_t>(std::ranges::min_element(weights) - weights.begin());
    if (weights[lowest] >= -on_edge) return EmbeddedPoint{x, c, weights};
    const auto nodes = mesh.cell(c);
    const auto next = mesh.across(c, nodes[(lowest + 1) % 3], nodes[(lowest + 2) % 3]);
    if (!next) break;
    c = *next;
  }
  // The walk left the tissue (it need not be convex): look everywhere.
  EmbeddedPoint best{x, -1, {}};
  double deepest = -std::numeric_limits<double>::infinity();
  for (int other = 0; other < mesh.n_cells() && deepest < 0; ++other) {
    const auto weights = weights_in(mesh, other, x);
    const double depth = depth_in(mesh, other, weights);
    if (!(depth > deepest)) continue;
    deepest = depth;
    best.cell = other;
    best.weights = weights;
  }
  if (deepest >= 0 || deepest >= -on_boundary * extent_of(mesh)) return best;
  return std::nullopt;
}

void relocate(const Mesh& mesh,
              std::span<const int> touched_cells,
              std::vector<EmbeddedPoint>& points) {
  for (auto& point : points) {
    if (std::ranges::find(touched_cells, point.cell) == touched_cells.end()) continue;
    const auto found = locate(mesh, point.x, point.cell);
    // A skin vertex may lie outside by the chord of a moved skin node: keep the nearest element.
    if (found) {
      point = *found;
    } else {
      point.weights = weights_in(mesh, point.cell, point.x);
    }
  }
}

}  // namespace stylet
