#include "stylet/mesh/embedded_point.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/quadratic.hpp"

#include <algorithm>
#include <limits>

namespace stylet {

namespace {

// A point on an edge is inside both of its cells, up to round-off of the barycentric coordinates.
constexpr double on_edge = 1e-9;
// Of the mesh's extent: what is left of a coordinate with eight digits, or turned by an angle that has
// them, on the wrong side of the boundary.
constexpr double on_boundary = 1e-8;

using Weights = std::array<double, 4>;

Weights weights_in(const Mesh& mesh, int c, ReferencePlace x) {
  if (mesh.dim() == 3) return barycentric(mesh.tetrahedron(c), x);
  const auto n = mesh.cell(c);
  const auto w = barycentric(mesh.point(n[0]), mesh.point(n[1]), mesh.point(n[2]), x.in_plane());
  return {w[0], w[1], w[2], 0};
}

// Of the triangle or the tetrahedron.
std::size_t lowest_of(const Mesh& mesh, const Weights& weights) {
  const auto end = weights.begin() + mesh.dim() + 1;
  return static_cast<std::size_t>(std::min_element(weights.begin(), end) - weights.begin());
}

/// How far inside a cell, as the least distance from the lines along its edges (3D: planes of its
/// faces); negative outside.
double depth_in(const Mesh& mesh, int c, const Weights& weights) {
  const auto n = mesh.cell(c);
  double depth = std::numeric_limits<double>::infinity();
  if (mesh.dim() == 3) {
    const auto t = mesh.tetrahedron(c);
    for (std::size_t i = 0; i < 4; ++i) {
      const ReferencePlace a = t[(i + 1) % 4];
      const double base = 0.5 * norm(cross(t[(i + 2) % 4] - a, t[(i + 3) % 4] - a));
      depth = std::min(depth, weights[i] * 3 * mesh.cell_measure(c) / base);
    }
    return depth;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const double base = distance(mesh.point(n[(i + 1) % 3]), mesh.point(n[(i + 2) % 3]));
    depth = std::min(depth, weights[i] * 2 * mesh.cell_measure(c) / base);
  }
  return depth;
}

double extent_of(const Mesh& mesh) {
  double extent = 0;
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    extent = std::max(extent, distance(mesh.place(0), mesh.place(node)));
  }
  return extent;
}

}  // namespace

std::vector<NodeWeight> node_weights(const Mesh& mesh, const EmbeddedPoint& point) {
  std::vector<NodeWeight> all;
  const auto nodes = mesh.nodes(point.cell);
  const auto& l = point.weights;
  const std::size_t n_corners = mesh.cell(point.cell).size();
  for (std::size_t k = 0; k < n_corners; ++k) {
    all.push_back({nodes[k], mesh.is_quadratic() ? l[k] * (2 * l[k] - 1) : l[k]});
  }
  for (std::size_t k = n_corners; k < nodes.size(); ++k) {
    const auto [a, b] = tetrahedron_edges[k - n_corners];
    all.push_back({nodes[k], 4 * l[a] * l[b]});
  }
  return all;
}

std::optional<EmbeddedPoint> locate(const Mesh& mesh, ReferencePlace x, int hint) {
  int c = hint;
  for (int steps = 0; steps < mesh.n_cells(); ++steps) {
    const auto weights = weights_in(mesh, c, x);
    const std::size_t lowest = lowest_of(mesh, weights);
    if (weights[lowest] >= -on_edge) return EmbeddedPoint{x, c, weights};
    const auto next = mesh.beyond(c, lowest);
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
