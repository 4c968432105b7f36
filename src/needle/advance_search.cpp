#include "stylet/needle/advance_search.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

AdvanceSearch::Next AdvanceSearch::next(double b,
                                        double g,
                                        std::optional<double> end,
                                        double tolerance) {
  if (std::abs(g) <= tolerance) return {Verdict::found, b};
  // The gap falls by as much as the tip advances, and by what the tissue gives.
  double slope = -1;
  if (last_ && last_->b != b) {
    const double secant = (g - last_->g) / (b - last_->b);
    const double shallowest = g > 0 ? -0.3 : 0;  // forward with care, back at will
    if (secant < shallowest) slope = secant;
  }
  last_ = {b, g};
  if (g > 0) {
    if (!too_short_ || b > too_short_->b) too_short_ = {b, g};
  } else if (!too_far_ || b < too_far_->b) {
    too_far_ = {b, g};
  }
  double to = b - g / slope;
  if (!too_far_) {
    if (end && b >= *end) return {Verdict::pass, b};
    // A tip in tissue that is squeezed flat gains little by its advance.
    constexpr int slow = 4;
    constexpr int most_doublings = 20;
    if (++same_side_ > slow) {
      to = b - g / slope * std::exp2(std::min(same_side_ - slow, most_doublings));
    }
    return {Verdict::move, end ? std::min(to, *end) : to};
  }
  same_side_ = 0;
  if (!too_short_) {
    // Less than nothing to cut: the tip sticks.
    if (b <= 0) return {Verdict::stick, 0};
    return {Verdict::move, std::max(0.0, to)};
  }
  const double low = too_short_->b;
  const double high = too_far_->b;
  constexpr double narrow = 1e-14;  // m
  // Where g jumps, the tip holds beyond the jump.
  if (high - low < narrow) return {Verdict::stick, high};
  // The line through both, and the middle where that has not halved the bracket twice in a row.
  const double width = high - low;
  constexpr int patience = 2;
  misses_ = width > 0.5 * width_ ? misses_ + 1 : 0;
  width_ = width;
  to = high + too_far_->g * width / (too_short_->g - too_far_->g);
  if (misses_ > patience || !(to > low && to < high)) to = 0.5 * (low + high);
  return {Verdict::move, to};
}

}  // namespace stylet
