// The scene's coordinates and those of the needle, which advances towards -x in its own.
//
// A scene with another direction of insertion is rotated when it is loaded and its results are
// rotated back when they are written, so that nothing in between knows.
#pragma once

#include "stylet/geometry/points.hpp"

#include <cmath>
#include <numbers>

namespace stylet {

class Rotation {
 public:
  /// angle: of the direction of insertion d, counter-clockwise from the scene's +x (rad). At pi both
  /// frames are the same, bit for bit.
  explicit Rotation(double angle = std::numbers::pi)
      : along_(angle == std::numbers::pi ? Vector2{-1, 0}
                                         : Vector2{std::cos(angle), std::sin(angle)}) {}

  [[nodiscard]] bool is_identity() const { return along_ == Vector2{-1, 0}; }

  /// (-d . v, n . v) with n = d turned by -90 degrees.
  [[nodiscard]] Vector2 to_needle(Vector2 v) const {
    return {-dot(along_, v), along_.y * v.x - along_.x * v.y};
  }
  [[nodiscard]] Vector2 to_scene(Vector2 v) const {
    return {-along_.x * v.x + along_.y * v.y, -along_.y * v.x - along_.x * v.y};
  }
  /// About z.
  [[nodiscard]] Vector3 to_scene(Vector3 v) const {
    const Vector2 turned = to_scene(Vector2{v.x, v.y});
    return {turned.x, turned.y, v.z};
  }
  template <class Frame>
  [[nodiscard]] SpacePoint<Frame> to_scene(SpacePoint<Frame> p) const {
    const Vector2 turned = to_scene(Vector2{p.x, p.y});
    return {turned.x, turned.y, p.z};
  }
  template <class Frame>
  [[nodiscard]] Point<Frame> to_needle(Point<Frame> p) const {
    const Vector2 v = to_needle(Vector2{p.x, p.y});
    return {v.x, v.y};
  }
  template <class Frame>
  [[nodiscard]] Point<Frame> to_scene(Point<Frame> p) const {
    const Vector2 v = to_scene(Vector2{p.x, p.y});
    return {v.x, v.y};
  }

 private:
  Vector2 along_;
};

}  // namespace stylet
