// A mesh as a reader or a generator leaves it: plain arrays, not yet checked.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace stylet {

/// Where cells, facets and nodes of a file come from, for the messages of `validate`, which empties
/// it. Each is empty or has one entry a cell, facet or node.
struct MeshOrigin {
  bool is_binary = false;  ///< places are bytes, else lines
  std::vector<std::int64_t> cell_number;
  std::vector<std::int64_t> cell_place;
  std::vector<std::int64_t> facet_number;
  std::vector<std::int64_t> facet_place;
  std::vector<std::int64_t> node_number;
};

/// The i-th of these; counted from 1 where there is no file.
[[nodiscard]] std::string number_in_file(const std::vector<std::int64_t>& numbers, int i);

/// A named curve that does not run along cells: refused where a scene uses it.
struct StrayCurve {
  std::string name;
  std::string fault;
};

/// Simplices in `dim` dimensions. Boundary pieces are "facets": edges in 2D, triangles in 3D.
struct MeshData {
  int dim = 2;
  std::vector<double> coordinates;  ///< dim numbers a node (m)
  std::vector<int> cells;           ///< dim + 1 nodes a cell
  std::vector<int> cell_region;     ///< index into region_names, one a cell
  std::vector<std::string> region_names;
  std::vector<int> facets;       ///< dim nodes a facet, of named boundaries and named inner curves
  std::vector<int> facet_curve;  ///< index into curve_names, one a facet
  /// Of quadratic tetrahedra (quadratic.hpp), else empty: the nodes of a cell, corners first (10), and of
  /// a facet (6).
  std::vector<int> quadratic_cells;
  std::vector<int> quadratic_facets;
  std::vector<std::string> curve_names;
  std::vector<StrayCurve> stray_curves;
  std::string source;  ///< file or generator, for messages
  MeshOrigin origin;

  [[nodiscard]] int n_nodes() const { return static_cast<int>(coordinates.size()) / dim; }
  [[nodiscard]] int n_cells() const { return static_cast<int>(cells.size()) / (dim + 1); }
  [[nodiscard]] int n_facets() const { return static_cast<int>(facets.size()) / dim; }

  [[nodiscard]] bool is_quadratic() const { return !quadratic_cells.empty(); }
  /// Nodes of all cells, corners and others; n_cell_nodes() each.
  [[nodiscard]] const std::vector<int>& cell_nodes() const {
    return is_quadratic() ? quadratic_cells : cells;
  }
  [[nodiscard]] int n_cell_nodes() const { return is_quadratic() ? 10 : dim + 1; }

  /// Takes curves and their facets out, for the reasons given.
  void make_stray(const std::map<int, std::string>& fault_of_curve);
};

}  // namespace stylet
