// The reference configuration: nodes, simplices, who touches whom, and the edits of the needle.
//
// Every rank holds the whole mesh (tens to hundreds of ranks, about 10 million cells); nodes are
// numbered so that a rank owns consecutive ones. The number of nodes and of cells never changes:
// the needle moves nodes and flips edges. No PETSc here.
#pragma once

#include "stylet/base/archive.hpp"
#include "stylet/geometry/points.hpp"
#include "stylet/geometry/tetrahedron.hpp"
#include "stylet/mesh/mesh_data.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace stylet {

class Mesh {
 public:
  /// Takes checked data (validate). Throws InputError where a cell is inverted.
  explicit Mesh(MeshData data);

  [[nodiscard]] int dim() const { return data_.dim; }
  [[nodiscard]] int n_nodes() const { return data_.n_nodes(); }
  [[nodiscard]] int n_cells() const { return data_.n_cells(); }
  [[nodiscard]] const MeshData& data() const { return data_; }

  [[nodiscard]] bool is_quadratic() const { return data_.is_quadratic(); }
  /// Corners of a cell (dim + 1), counter-clockwise in 2D.
  [[nodiscard]] std::span<const int> cell(int c) const {
    const auto width = static_cast<std::size_t>(data_.dim) + 1;
    return {data_.cells.data() + static_cast<std::size_t>(c) * width, width};
  }
  /// All nodes of a cell: its corners, and behind them the mid-edge nodes of a quadratic one.
  [[nodiscard]] std::span<const int> nodes(int c) const {
    const auto width = static_cast<std::size_t>(data_.n_cell_nodes());
    return {data_.cell_nodes().data() + static_cast<std::size_t>(c) * width, width};
  }
  /// Coordinates of a node (dim numbers, m).
  [[nodiscard]] std::span<const double> coordinates(int node) const {
    const auto width = static_cast<std::size_t>(data_.dim);
    return {data_.coordinates.data() + static_cast<std::size_t>(node) * width, width};
  }
  /// 2D.
  [[nodiscard]] ReferencePoint point(int node) const {
    const auto x = coordinates(node);
    return {x[0], x[1]};
  }
  [[nodiscard]] ReferencePlace place(int node) const {
    const auto x = coordinates(node);
    return {x[0], x[1], dim() == 3 ? x[2] : 0};
  }
  /// Corners of a cell. 3D.
  [[nodiscard]] Tetrahedron<ReferenceFrame> tetrahedron(int c) const {
    const auto n = cell(c);
    return {place(n[0]), place(n[1]), place(n[2]), place(n[3])};
  }
  [[nodiscard]] int region(int c) const { return data_.cell_region[static_cast<std::size_t>(c)]; }
  /// Cells around a node, ascending.
  [[nodiscard]] std::span<const int> cells_around(int node) const {
    return around_[static_cast<std::size_t>(node)];
  }
  /// Nodes that share a cell with a node, and itself; ascending.
  [[nodiscard]] std::vector<int> neighbours(int node) const;
  /// The cell beyond the edge a-b, seen from cell c; none at the boundary. 2D.
  [[nodiscard]] std::optional<int> across(int c, int a, int b) const;
  /// The cell beyond the edge (3D: face) opposite to a corner, 0 to dim; none at the boundary.
  [[nodiscard]] std::optional<int> beyond(int c, std::size_t corner) const;
  /// One or two cells that hold both nodes.
  [[nodiscard]] std::vector<int> cells_with(int a, int b) const;
  /// The node of a triangle that is neither a nor b.
  [[nodiscard]] int opposite(int c, int a, int b) const;

  [[nodiscard]] bool on_boundary(int node) const {
    return on_boundary_[static_cast<std::size_t>(node)];
  }
  /// Nodes of the outer boundary and of locked curves must stay where they are.
  [[nodiscard]] bool is_locked(int node) const { return locked_[static_cast<std::size_t>(node)]; }
  /// Locks the nodes (2D: and edges) of a named curve that carries a condition or a load.
  void lock_curve(const std::string& curve);
  /// True for edges of the outer boundary, of locked curves and between regions.
  [[nodiscard]] bool is_locked_edge(int a, int b) const;
  /// Facets of a named curve (3D: surface) as indices into data().facets (units of dim nodes); throws
  /// InputError that lists the curves if the name is unknown.
  [[nodiscard]] std::vector<int> facets_of(const std::string& curve) const;
  /// Corners of a facet (dim of them).
  [[nodiscard]] std::span<const int> facet(int f) const {
    const auto width = static_cast<std::size_t>(data_.dim);
    return {data_.facets.data() + static_cast<std::size_t>(f) * width, width};
  }
  /// All nodes of a facet: 6 of a quadratic one, corners first.
  [[nodiscard]] std::span<const int> facet_nodes(int f) const {
    if (!is_quadratic()) return facet(f);
    return {data_.quadratic_facets.data() + 6 * static_cast<std::size_t>(f), 6};
  }
  /// Length or area of a facet.
  [[nodiscard]] double facet_measure(int f) const;
  [[nodiscard]] int region_index(const std::string& name) const;
  /// Distinct nodes of a named curve, ascending.
  [[nodiscard]] std::vector<int> nodes_of(const std::string& curve) const;

  /// Area or volume of a cell; negative if inverted.
  [[nodiscard]] double cell_measure(int c) const;
  /// Quality of a cell, see geometry/triangle.hpp and geometry/tetrahedron.hpp.
  [[nodiscard]] double cell_quality(int c) const;
  [[nodiscard]] double worst_quality(std::span<const int> cells) const;

  // Edits, in 2D. Each raises version(); connectivity_version() rises with flips only.
  void move_node(int node, ReferencePoint to);
  /// Replaces the edge a-b of two triangles by the edge between their opposite nodes. Returns those
  /// nodes. The caller checks that the result is valid.
  std::array<int, 2> flip_edge(int a, int b);
  /// Nodes and cells go back to those of `source`, of which this mesh has been made by edits. Returns the
  /// cells that change, ascending.
  std::vector<int> put_back(const MeshData& source);
  [[nodiscard]] std::uint64_t version() const { return version_; }
  [[nodiscard]] std::uint64_t connectivity_version() const { return connectivity_version_; }

  /// What edits change; loaded into the mesh that it was before them.
  void archive(Archive& archive);

 private:
  MeshData data_;
  std::vector<std::vector<int>> around_;
  std::vector<char> on_boundary_;
  std::vector<char> locked_;
  std::vector<std::uint64_t> locked_edges_;  ///< sorted keys
  std::uint64_t version_ = 0;
  std::uint64_t connectivity_version_ = 0;
};

}  // namespace stylet
