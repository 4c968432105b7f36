#include "stylet/mesh/embedded_point.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/geometry/triangle.hpp"

#include <algorithm>
#include <limits>

namespace stylet {

namespace {

// A point on an edge is inside both of its cells, up to round-off of the barycentric coordinates.
constexpr double on_edge = 1e-9;

std::array<double, 3> weights_in(const Mesh& mesh, int c, ReferencePoint x) {
  const auto nodes = mesh.cell(c);
  return barycentric(mesh.point(nodes[0]), mesh.point(nodes[1]), mesh.point(nodes[2]), x);
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
  double inside = -std::numeric_limits<double>::infinity();
  for (int other = 0; other < mesh.n_cells(); ++other) {
    const auto weights = weights_in(mesh, other, x);
    const double lowest = *std::ranges::min_element(weights);
    if (lowest > inside) {
      inside = lowest;
      best.cell = other;
      best.weights = weights;
      if (lowest >= 0) break;
    }
  }
  if (inside >= -on_edge) return best;
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
