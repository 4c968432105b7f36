// The skin around the point where a needle enters: it carries the part of the tip that is not in yet.
#pragma once

#include "stylet/mesh/mesh.hpp"

#include <vector>

namespace stylet {

/// Length (m) or share of a line that belongs to a node.
struct NodeShare {
  int node;
  double value;
};

class Skin {
 public:
  Skin() = default;
  /// Boundary nodes that follow each other, as far as `reach` (m) from the entry node on either side,
  /// or to a corner of the tissue.
  Skin(const Mesh& mesh, int entry, double reach);

  /// Integrals of the nodes' hat functions along the skin over `width` (m), centred at the entry.
  /// Less where a corner is closer than half of it.
  [[nodiscard]] std::vector<NodeShare> lengths(const Mesh& mesh, double width) const;
  [[nodiscard]] const std::vector<int>& nodes() const { return nodes_; }
  void archive(Archive& archive);

 private:
  std::vector<int> nodes_;  ///< from one end to the other
  std::size_t entry_ = 0;   ///< which of them is the entry
};

/// The one or two nodes that follow a boundary node along the boundary.
[[nodiscard]] std::vector<int> boundary_neighbours(const Mesh& mesh, int node);

/// True where the boundary turns by more than 30 degrees.
[[nodiscard]] bool is_corner(const Mesh& mesh, int node);

}  // namespace stylet
