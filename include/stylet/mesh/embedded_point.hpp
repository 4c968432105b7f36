// Points fixed in the reference frame, carried by the element that holds them: membrane vertices,
// seeds, probes. When the needle moves nodes they are found again by walking (constant time).
#pragma once

#include "stylet/base/archive.hpp"
#include "stylet/geometry/points.hpp"
#include "stylet/mesh/mesh.hpp"

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace stylet {

/// x = sum of weights times the corners of the cell.
struct EmbeddedPoint {
  ReferencePlace x;
  int cell = -1;
  std::array<double, 4> weights{};  ///< the last one is 0 in 2D
};

void archive(Archive& archive, EmbeddedPoint& point);

/// What a node of a cell counts for at a point in it.
struct NodeWeight {
  int node;
  double weight;  ///< the value of its shape function
};

/// Of all nodes of the point's cell, in the order of mesh.nodes: the barycentric weights, or those of the
/// quadratic shape functions L (2 L - 1) of corners and 4 L M of the middles of edges.
[[nodiscard]] std::vector<NodeWeight> node_weights(const Mesh& mesh, const EmbeddedPoint& point);

/// Walks from cell `hint` to the cell that holds x. None if x lies outside the tissue by more than
/// round-off.
[[nodiscard]] std::optional<EmbeddedPoint> locate(const Mesh& mesh, ReferencePlace x, int hint = 0);

/// Finds the points again whose cells were touched by an edit.
void relocate(const Mesh& mesh,
              std::span<const int> touched_cells,
              std::vector<EmbeddedPoint>& points);

}  // namespace stylet
