// Which material a moved element consists of.
//
// Regions keep their shape while the needle moves nodes across their boundaries: the mesh as it was
// read is kept as a background, and an edited element takes the mixture of the regions below it.
#pragma once

#include "stylet/mesh/mesh.hpp"

#include <utility>
#include <vector>

namespace stylet {

class RegionMap {
 public:
  /// Keeps a copy of the mesh before the first edit.
  explicit RegionMap(const Mesh& initial) : initial_(initial) {}

  /// (region, share) of the area of a cell of the edited mesh; shares sum to 1. Exact, and so
  /// continuous in the places of the nodes: an element whose stiffness jumped as the tip moves on
  /// would leave the cutting law without a solution.
  [[nodiscard]] std::vector<std::pair<int, double>> shares(const Mesh& mesh, int cell) const;

 private:
  Mesh initial_;
};

}  // namespace stylet
