// The friction law of the shaft (paper, sec. V.B), of one point that stands for a length of path (m).
// Speeds are those of the needle relative to the tissue there (m/s).
#pragma once

#include "stylet/needle/parameters.hpp"

#include <cmath>

namespace stylet {

/// Largest force (N) of a point that sticks. has_slid: in this step, where its limit must not depend on
/// what it does (ShaftContacts).
[[nodiscard]] inline double holding_force(const FrictionParameters& law,
                                          double length,
                                          bool has_slid) {
  return (has_slid ? law.kinetic_force : law.static_force) * length;
}

/// Force (N) of a point that slides: the part that does not depend on how fast,
[[nodiscard]] inline double sliding_force(const FrictionParameters& law, double length) {
  return law.kinetic_force * length;
}

/// and the viscous part, for each m/s (N s/m).
[[nodiscard]] inline double viscous_coefficient(const FrictionParameters& law, double length) {
  return law.viscous_coefficient * length;
}

/// True if a point that slides so slowly sticks from the next step on.
[[nodiscard]] inline bool is_caught(const FrictionParameters& law, double speed) {
  return std::abs(speed) < law.stick_speed;
}

/// True if a point that the needle reaches again slides.
[[nodiscard]] inline bool slides_at_once(const FrictionParameters& law, double speed) {
  return std::abs(speed) > law.slip_speed;
}

/// True if the friction of a sliding point would push it on, beyond round-off: it sticks.
[[nodiscard]] inline bool drives(const FrictionParameters& law, double slip_sign, double speed) {
  const double noise = 1e-9 * law.stick_speed;
  return slip_sign * speed < -noise;
}

}  // namespace stylet
