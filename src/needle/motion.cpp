#include "stylet/needle/motion.hpp"

#include "stylet/needle/stops.hpp"

#include <cmath>

namespace stylet {

void Motion::enter(double skin_along, double along_sign) {
  along_sign_ = along_sign;
  skin_ = skin_along;
  tip_ = skin_along;
}

std::optional<double> Motion::target() const {
  const Action& a = action();
  if (a.kind != ActionKind::insert && a.kind != ActionKind::retract) return std::nullopt;
  if (a.position) return along_sign_ * *a.position;
  if (a.depth) return skin_ + *a.depth;
  return std::nullopt;  // all the way out
}

bool Motion::is_no_motion() const {
  const auto end = target();
  return end && stylet::is_no_motion(tip_, *end);
}

NeedleStep Motion::next(double longest) {
  const Action& a = action();
  const auto end = target();
  std::optional<double> remaining;
  if (end) remaining = std::abs(*end - tip_) / a.speed;
  if (a.duration) remaining = *a.duration - elapsed_;
  if (h_ == 0 || h_ > longest * (1 + 1e-12)) {
    h_ = longest;
    left_ = 0;
    if (remaining) {
      constexpr double round_off = 1e-9;
      left_ = std::max(1LL, std::llround(std::ceil(*remaining / longest - round_off)));
      h_ = *remaining / static_cast<double>(left_);
    }
  }
  NeedleStep step{h_, tip_, tip_};
  if (a.kind == ActionKind::insert || a.kind == ActionKind::retract) {
    double sign = a.kind == ActionKind::insert ? 1 : -1;
    if (end) sign = *end >= tip_ ? 1 : -1;
    step.to = end && left_ == 1 ? *end : tip_ + sign * a.speed * h_;
  }
  return step;
}

void Motion::commit(const NeedleStep& step) {
  tip_ = step.to;
  elapsed_ += step.h;
  if (left_ > 0 && --left_ == 0) finish_action();
}

void Motion::finish_action() {
  ++at_;
  elapsed_ = 0;
  h_ = 0;
  left_ = 0;
}

}  // namespace stylet
