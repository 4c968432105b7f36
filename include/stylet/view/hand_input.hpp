// From mouse and keys to what the hand wants. Knows no window, so that tests can move the mouse.
#pragma once

#include "stylet/view/camera.hpp"
#include "stylet/view/frame.hpp"
#include "stylet/view/live_run.hpp"

#include <optional>
#include <variant>

namespace stylet {

/// Keys that are held down now.
struct HeldKeys {
  bool left = false;
  bool right = false;
  bool up = false;
  bool down = false;
  bool slow = false;
};

class HandInput {
 public:
  void press(Pixel at, const Frame& frame, const Camera& camera);
  void release(const Frame& frame);
  void move(Pixel to, const Frame& frame, const Camera& camera);
  /// Once a picture; seconds: since the last one.
  void keys(const HeldKeys& held, const Frame& frame, double seconds);
  [[nodiscard]] bool holds() const { return grip_.has_value(); }
  /// What is wanted now; none: nothing new.
  [[nodiscard]] std::optional<std::variant<Aim, Push>> take();

 private:
  void let_go_after_undo(const Frame& frame);

  std::optional<double> grip_;  ///< place under the mouse less that of the tip (m, along)
  double height_ = 0;           ///< of the needle while it is held (m)
  bool pushes_ = false;         ///< by keys
  int epoch_ = 0;
  std::optional<std::variant<Aim, Push>> wanted_;
};

/// Across and along coordinate of a point (m), in the needle's coordinates.
struct NeedlePlace {
  double height = 0;
  double along = 0;
};
[[nodiscard]] NeedlePlace place_of(WorldPoint x, double needle_angle);

}  // namespace stylet
