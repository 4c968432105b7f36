#include "stylet/simulation/settling.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/simulation/point_text.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace stylet {

namespace {

constexpr double most_steps = 3e5;  // still to come
constexpr int most_hopeless_blocks = 3;

}  // namespace

bool Settling::is_settled(double speed, double tolerance) {
  if (speed <= tolerance) return true;
  double& peak = 2 * step_ < block_ ? first_half_ : second_half_;
  peak = std::max(peak, speed);
  if (++step_ < block_) return false;
  // By this factor in half a block.
  const double fall = std::log(first_half_ / second_half_);
  const double blocks = std::log(second_half_ / tolerance) / fall;
  const double steps_left = 0.5 * static_cast<double>(block_) * blocks;
  const bool hopeless = !(fall > 0) || steps_left > most_steps;
  hopeless_blocks_ = hopeless ? hopeless_blocks_ + 1 : 0;
  if (hopeless_blocks_ == most_hopeless_blocks) {
    throw NumericalError(
        "the tissue does not come to rest: its largest speed, " + brief(second_half_) + " m/s, " +
        (fall > 0 ? "would need " + brief(steps_left) + " more steps to fall to "
                  : "does not fall to ") +
        "the speed_tolerance of settle, " + brief(tolerance) +
        " m/s; give settle a duration or a larger speed_tolerance, or the tissue damping");
  }
  block_ *= 2;
  step_ = 0;
  first_half_ = 0;
  second_half_ = 0;
  return false;
}

}  // namespace stylet
