// The cutting law of the tip (src/MODEL.md, section 5): forces at which it cuts.
#pragma once

#include "stylet/needle/parameters.hpp"

#include <algorithm>

namespace stylet {

/// Of a needle in tissue of the reference stiffness (N).
[[nodiscard]] inline double nominal_force(const CuttingParameters& law) {
  return law.cutting_force / law.sharpness;
}

/// Of a tip that is in with all of its length (N); modulus: of the tissue ahead (Pa).
[[nodiscard]] inline double full_force(const CuttingParameters& law, double modulus) {
  if (law.stiffness_share <= 0) return nominal_force(law);
  return nominal_force(law) *
         (1 + law.stiffness_share * (modulus / law.reference_youngs_modulus - 1));
}

/// Of the tip's one condition (N), as in Trial.
struct Multiplier {
  // NOLINTNEXTLINE(google-explicit-constructor): one number where all are the same
  Multiplier(double all) : needed(all), working(all), settled(all) {}
  Multiplier(double with_blow, double that_works, double after_blow)
      : needed(with_blow), working(that_works), settled(after_blow) {}
  /// By which cutting is decided: before a blow or after it the smaller one, so that a cut that follows
  /// lets the tissue fall back. Backward Euler has one force over the whole step.
  [[nodiscard]] double bearing() const {
    const bool one_force = needed == working;
    return std::min(one_force ? needed : 2 * working - settled, settled);
  }
  double needed;
  double working;
  double settled;
};

}  // namespace stylet
