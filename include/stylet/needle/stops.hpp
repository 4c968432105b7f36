// Where a list of actions takes the tip: known before the run, but for the skin where it moves.
#pragma once

#include "stylet/needle/parameters.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace stylet {

/// A place along the axis (m), as seen from the scene or from the skin at the time of entry.
struct Stop {
  double along = 0;
  bool from_skin = true;
};

/// What an action does to the tip.
struct Travel {
  Stop from;
  Stop to;
  bool all_out =
      false;  ///< a retract without an end: the tip comes to stand at the skin or before it
};

/// One an action. The tip first stands at the skin.
[[nodiscard]] std::vector<Travel> travels_of(std::span<const Action> actions, double along_sign);

/// Coordinate along the axis (m).
[[nodiscard]] inline double along_of(const Stop& stop, double skin) {
  return stop.from_skin ? skin + stop.along : stop.along;
}

/// Shorter than the round-off of the coordinates it is between: no motion.
[[nodiscard]] bool is_no_motion(double from, double to);

/// An action that cannot be done as it stands, and why.
struct MotionFault {
  std::size_t action = 0;
  std::string reason;
};

/// The first insert that goes back or ends in front of the skin, retract that goes in, implant with
/// the tip outside. skin_known: else only what holds wherever the skin is.
[[nodiscard]] std::optional<MotionFault> find_fault(std::span<const Action> actions,
                                                    double along_sign,
                                                    double skin,
                                                    bool skin_known);

}  // namespace stylet
