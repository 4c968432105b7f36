// Natural frequencies of the supported tissue, K x = omega^2 M x, through SLEPc.
#pragma once

#include "stylet/fem/tissue_operator.hpp"
#include "stylet/solvers/constraint_set.hpp"

#include <span>
#include <vector>

namespace stylet {

/// Collective. The n smallest angular frequencies (rad/s), ascending, with the given dofs held. The
/// shift is just below zero, so that rigid-body modes of unsupported tissue (omega = 0) are found
/// too. SLEPc options: -eps_*, -st_*. Throws NumericalError if fewer converge.
[[nodiscard]] std::vector<double> natural_frequencies(const TissueOperator& tissue,
                                                      std::span<const int> held_dofs,
                                                      int n);

/// Collective. Square of the largest angular frequency (rad/s)^2, on the motions that leave the
/// constraints' dofs and mean where they are. Needs a lumped operator. SLEPc options: -eps_*.
[[nodiscard]] double largest_frequency_squared(const TissueOperator& tissue,
                                               const ConstraintSet& constraints);

}  // namespace stylet
