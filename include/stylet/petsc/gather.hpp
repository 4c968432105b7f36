// How a few entries of distributed vectors reach every rank.
#pragma once

#include <petscvec.h>

#include <span>
#include <vector>

namespace stylet {

/// Collective. Values of the given dofs of each vector, on every rank with the same bits:
/// result[vector][i] belongs to dofs[i].
[[nodiscard]] std::vector<std::vector<double>> gather(std::span<const Vec> vectors,
                                                      std::span<const int> dofs);

/// Collective. All values of a vector, on every rank.
[[nodiscard]] std::vector<double> gather_all(Vec vector);

/// Sets a dof where this rank owns it. Not collective; no assembly needed.
void set_owned(Vec vector, int dof, double value);

}  // namespace stylet
