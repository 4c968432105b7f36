// The state of the tissue and how a few nodes of it reach every rank.
#pragma once

#include "stylet/petsc/owned.hpp"

#include <span>
#include <vector>

namespace stylet {

/// Time and nodal displacement, velocity and acceleration (dof = 2 node + component).
struct State {
  double t = 0;
  OwnedVec u;
  OwnedVec v;
  OwnedVec a;
};

/// Both dofs of each node, in the order of the nodes.
[[nodiscard]] std::vector<int> dofs_of(std::span<const int> nodes);

/// Collective. Values of the given dofs of each vector, on every rank with the same bits:
/// result[vector][i] belongs to dofs[i].
[[nodiscard]] std::vector<std::vector<double>> gather(std::span<const Vec> vectors,
                                                      std::span<const int> dofs);

/// Collective. All values of a vector, on every rank.
[[nodiscard]] std::vector<double> gather_all(Vec vector);

/// Sets a dof where this rank owns it. Not collective; no assembly needed.
void set_owned(Vec vector, int dof, double value);

}  // namespace stylet
