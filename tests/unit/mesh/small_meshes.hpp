// Meshes that the tests of this folder share.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/rectangle.hpp"

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

inline double total_area(const Mesh& mesh) {
  double area = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) area += mesh.cell_measure(c);
  return area;
}

}  // namespace stylet
