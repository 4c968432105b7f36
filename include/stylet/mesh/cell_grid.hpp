// Finds the tetrahedron at a place in constant time, wherever the last one was.
#pragma once

#include "stylet/geometry/points.hpp"
#include "stylet/mesh/embedded_point.hpp"
#include "stylet/mesh/mesh.hpp"

#include <array>
#include <optional>
#include <vector>

namespace stylet {

/// The boxes of a regular grid, and which cells may reach into each.
class CellGrid {
 public:
  /// Of the places between two corners; spacing (m): about the length of an edge. The mesh is lent.
  CellGrid(const Mesh& mesh, ReferencePlace low, ReferencePlace high, double spacing);

  /// Of the cells that hold x the one with the lowest number. None if x lies outside the tissue, or
  /// outside the grid.
  [[nodiscard]] std::optional<EmbeddedPoint> find(ReferencePlace x) const;

 private:
  using Index = std::array<int, 3>;
  [[nodiscard]] Index index_of(ReferencePlace x) const;
  [[nodiscard]] bool holds(const Index& i) const;
  [[nodiscard]] std::size_t box(const Index& i) const;

  const Mesh& mesh_;
  ReferencePlace low_;
  double spacing_;
  Index size_;
  std::vector<std::vector<int>> cells_;
};

}  // namespace stylet
