// Meshes that the tests of this folder share.
#pragma once

#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/rectangle.hpp"

#include <algorithm>

namespace stylet {

/// Nodes 0 (0, 0), 1 (1, 0), 2 (1, 1), 3 (0, 1); cells (0, 1, 2) and (0, 2, 3).
inline MeshData square() {
  MeshData data;
  data.coordinates = {0, 0, 1, 0, 1, 1, 0, 1};
  data.cells = {0, 1, 2, 0, 2, 3};
  data.cell_region = {0, 0};
  data.region_names = {"tissue"};
  data.facets = {0, 1, 1, 2};
  data.facet_curve = {0, 1};
  data.curve_names = {"bottom", "right"};
  data.source = "square";
  return data;
}

/// 2 x 1 with random nodes, 12 x 6 squares, and an ellipse `core`.
inline MeshData shaken_rectangle() {
  RectangleMesh p;
  p.width = 2;
  p.height = 1;
  p.columns = 12;
  p.rows = 6;
  p.jitter = 0.2;
  p.inner_regions.push_back({"core", Ellipse{{1, 0.5}, 1.1, 0.6}});
  return make_rectangle(p);
}

/// Flips an edge if both new triangles have at least this quality. (A flip that inverts a triangle
/// may double an edge and cannot be taken back.)
inline bool flip_if_valid(Mesh& mesh, int a, int b, double least) {
  if (mesh.is_locked_edge(a, b)) return false;
  const auto both = mesh.cells_with(a, b);
  const auto c = mesh.point(mesh.opposite(both[0], a, b));
  const auto d = mesh.point(mesh.opposite(both[1], a, b));
  const double turn = signed_area(mesh.point(a), mesh.point(b), c) > 0 ? 1 : -1;
  const double worst =
      std::min(turn * quality(mesh.point(a), d, c), turn * quality(d, mesh.point(b), c));
  if (!(worst >= least)) return false;
  mesh.flip_edge(a, b);
  return true;
}

inline double total_area(const Mesh& mesh) {
  double area = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) area += mesh.cell_measure(c);
  return area;
}

}  // namespace stylet
