// Edits all over a mesh, for tests.
#pragma once

#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/mesh.hpp"

#include <random>
#include <vector>

namespace stylet {

/// Moves every inner node at random within what keeps the triangles valid. Returns touched cells.
inline std::vector<int> move_nodes(Mesh& mesh, std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-1.5e-3, 1.5e-3);
  std::vector<int> touched;
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    if (mesh.on_boundary(node)) continue;
    const ReferencePoint old = mesh.point(node);
    mesh.move_node(node, old + Vector2{shift(random), shift(random)});
    const auto around = mesh.cells_around(node);
    if (mesh.worst_quality(around) < 0.1) mesh.move_node(node, old);
    touched.insert(touched.end(), around.begin(), around.end());
  }
  return touched;
}

/// Flips an edge of every third cell where that is valid. Returns touched cells.
inline std::vector<int> flip_edges(Mesh& mesh) {
  std::vector<int> touched;
  for (int c = 0; c < mesh.n_cells(); c += 3) {
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = mesh.cell(c)[i];
      const int b = mesh.cell(c)[(i + 1) % 3];
      if (mesh.is_locked_edge(a, b)) continue;
      const auto other = mesh.across(c, a, b);
      if (!other) continue;
      const auto far = mesh.point(mesh.opposite(*other, a, b));
      const auto mine = mesh.point(mesh.opposite(c, a, b));
      if (quality(mine, mesh.point(a), far) < 0.1 || quality(mine, far, mesh.point(b)) < 0.1)
        continue;
      mesh.flip_edge(a, b);
      touched.push_back(c);
      touched.push_back(*other);
      break;
    }
  }
  return touched;
}

}  // namespace stylet
