// The state of the tissue.
#pragma once

#include "stylet/petsc/gather.hpp"
#include "stylet/petsc/owned.hpp"

#include <span>
#include <vector>

namespace stylet {

/// Time and nodal displacement, velocity and acceleration (dof = dim node + component).
struct State {
  double t = 0;
  OwnedVec u;
  OwnedVec v;
  OwnedVec a;
};

/// All dofs of each node, in the order of the nodes.
[[nodiscard]] std::vector<int> dofs_of(std::span<const int> nodes, int dim);
/// In the plane, where needles are.
[[nodiscard]] inline std::vector<int> dofs_of(std::span<const int> nodes) {
  return dofs_of(nodes, 2);
}

}  // namespace stylet
