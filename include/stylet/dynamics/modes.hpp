// Natural frequencies of the supported tissue, K x = omega^2 M x, through SLEPc.
#pragma once

#include "stylet/dynamics/constraint_set.hpp"
#include "stylet/fem/tissue_operator.hpp"

#include <span>
#include <vector>

namespace stylet {

/// Collective. The n smallest angular frequencies (rad/s), ascending, with the given dofs held. The
/// shift is just below zero, so that rigid-body modes of unsupported tissue (omega = 0) are found
/// too. SLEPc options: -eps_*, -st_*. Throws NumericalError if fewer converge.
[[nodiscard]] std::vector<double> natural_frequencies(const TissueOperator& tissue,
                                                      std::span<const int> held_dofs,
                                                      int n);

/// Squares of angular frequencies, (rad/s)^2.
struct LargestFrequency {
  double squared = 0;  ///< largest eigenvalue of M^-1 K, by SLEPc
  double row_sums =
      0;  ///< never below it: largest absolute row sum of M^-1/2 K M^-1/2 (Gershgorin)
};

/// Collective. On the motions that leave the constraints' dofs and mean where they are; the row sums
/// do not know of the mean, which can only lower the frequency. Needs a lumped operator. SLEPc
/// options: -eps_*.
[[nodiscard]] LargestFrequency largest_frequency(const TissueOperator& tissue,
                                                 const ConstraintSet& constraints);

}  // namespace stylet
