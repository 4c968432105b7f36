#include "stylet/view/hand_input.hpp"

#include "stylet/geometry/rotation.hpp"
#include "stylet/needle/axis.hpp"

#include <cmath>
#include <utility>

namespace stylet {

NeedlePlace place_of(WorldPoint x, double needle_angle) {
  const WorldPoint p = Rotation(needle_angle).to_needle(x);
  return {Axis::across(p), Axis::along(p)};
}

void HandInput::let_go_after_undo(const Frame& frame) {
  if (frame.epoch == epoch_) return;
  epoch_ = frame.epoch;
  grip_.reset();
  pushes_ = false;
}

void HandInput::press(Pixel at, const Frame& frame, const Camera& camera) {
  let_go_after_undo(frame);
  const NeedlePlace place = place_of(camera.point_at(at), frame.needle_angle);
  height_ = frame.needle.in_tissue ? frame.height : place.height;
  grip_ = place.along - frame.tip;
  wanted_ = Aim{height_, frame.tip};
}

void HandInput::release(const Frame& frame) {
  if (!grip_) return;
  grip_.reset();
  wanted_ = Push{frame.height, 0};
}

void HandInput::move(Pixel to, const Frame& frame, const Camera& camera) {
  let_go_after_undo(frame);
  const NeedlePlace place = place_of(camera.point_at(to), frame.needle_angle);
  if (grip_) {
    wanted_ = Aim{height_, place.along - *grip_};
  } else if (!frame.needle.in_tissue && !pushes_ && !frame.replays) {
    wanted_ = Push{place.height, 0};
  }
}

void HandInput::keys(const HeldKeys& held, const Frame& frame, double seconds) {
  let_go_after_undo(frame);
  if (grip_) return;
  // The arrow that points where the needle goes pushes it.
  const double x = std::cos(frame.needle_angle);
  const double y = std::sin(frame.needle_angle);
  const double right = (held.right ? 1 : 0) - (held.left ? 1 : 0);
  const double up = (held.up ? 1 : 0) - (held.down ? 1 : 0);
  const bool lies = std::abs(x) >= std::abs(y);
  const double push = lies ? right * (x > 0 ? 1 : -1) : up * (y > 0 ? 1 : -1);
  const double aside = lies ? up * (x > 0 ? -1 : 1) : right * (y > 0 ? 1 : -1);
  constexpr double usual = 0.5;  // of the limit: that of the scene's own hand
  constexpr double slowly = 0.1;
  constexpr double sideways = 0.01;  // m/s
  const double factor = held.slow ? slowly : usual;
  if (push != 0) {
    pushes_ = true;
    wanted_ = Push{frame.height, factor * push * frame.speed_limit};
  } else if (aside != 0 && !frame.needle.in_tissue) {
    wanted_ = Push{frame.height + 2 * factor * aside * sideways * seconds, 0};
  } else if (std::exchange(pushes_, false)) {
    wanted_ = Push{frame.height, 0};
  }
}

std::optional<std::variant<Aim, Push>> HandInput::take() {
  return std::exchange(wanted_, std::nullopt);
}

}  // namespace stylet
