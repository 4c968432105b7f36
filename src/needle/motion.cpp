#include "stylet/needle/motion.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/needle/stops.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stylet {

void Motion::enter(double skin_along, double along_sign) {
  along_sign_ = along_sign;
  skin_ = skin_along;
  tip_ = skin_along;
  go_on(false);
}

std::optional<double> Motion::target() const {
  const Action& a = action();
  if (a.kind != ActionKind::insert && a.kind != ActionKind::retract) return std::nullopt;
  if (a.position) return along_sign_ * *a.position;
  if (a.depth) return skin_ + *a.depth;
  return std::nullopt;  // all the way out
}

Awaited Motion::awaits() const {
  if (finished()) return Awaited::nothing;
  const Action& a = action();
  if (a.kind == ActionKind::retract && !target()) return Awaited::withdrawal;
  if (a.kind == ActionKind::settle && !a.duration) return Awaited::rest;
  return Awaited::nothing;
}

// The one place where an action ends, but for an implant.
bool Motion::is_over(bool awaited) const {
  if (awaits() != Awaited::nothing) return awaited;
  if (const auto end = target()) return is_no_motion(tip_, *end);
  return action().duration && h_ > 0 && left_ == 0;
}

void Motion::go_on(bool awaited) {
  while (!finished() && is_over(std::exchange(awaited, false))) {
    ++at_;
    elapsed_ = 0;
    h_ = 0;
    left_ = 0;
  }
}

bool Motion::will_implant() const {
  const auto next = actions_.begin() + static_cast<std::ptrdiff_t>(at_) + 1;
  return std::any_of(next, actions_.end(),
                     [](const Action& a) { return a.kind == ActionKind::implant; });
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

void Motion::taken(const NeedleStep& step, bool awaited) {
  tip_ = step.to;
  elapsed_ += step.h;
  if (left_ > 0) --left_;
  go_on(awaited);
}

void Motion::change_end(double before) {
  if (finished()) elapsed_ = before;
  constexpr double round_off = 1e-9;
  const double duration = *actions_.front().duration;
  if (elapsed_ > duration * (1 + round_off)) {
    throw InputError("key 'time.duration': is " + exact(duration) +
                     " s, and the state is one after " + exact(elapsed_) +
                     " s; allowed on --resume: that and more");
  }
  at_ = elapsed_ < duration * (1 - round_off) ? 0 : actions_.size();
  h_ = 0;
  left_ = 0;
}

void Motion::implanted() {
  ++at_;
  go_on(false);
}

}  // namespace stylet
