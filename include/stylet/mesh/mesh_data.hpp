// A mesh as a reader or a generator leaves it: plain arrays, not yet checked.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace stylet {

/// Simplices in `dim` dimensions. Boundary pieces are "facets": edges in 2D, triangles in 3D.
struct MeshData {
  int dim = 2;
  std::vector<double> coordinates;  ///< dim numbers a node (m)
  std::vector<int> cells;           ///< dim + 1 nodes a cell
  std::vector<int> cell_region;     ///< index into region_names, one a cell
  std::vector<std::string> region_names;
  std::vector<int> facets;       ///< dim nodes a facet, of named boundaries and named inner curves
  std::vector<int> facet_curve;  ///< index into curve_names, one a facet
  std::vector<std::string> curve_names;
  std::string source;  ///< file or generator, for messages

  [[nodiscard]] int n_nodes() const { return static_cast<int>(coordinates.size()) / dim; }
  [[nodiscard]] int n_cells() const { return static_cast<int>(cells.size()) / (dim + 1); }
  [[nodiscard]] int n_facets() const { return static_cast<int>(facets.size()) / dim; }
};

}  // namespace stylet
