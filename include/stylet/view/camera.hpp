// Which part of the plane is seen where on the screen. Pixels count from the upper left corner, as
// windows have them; a pixel may be shown by several of a fine display.
#pragma once

#include "stylet/geometry/points.hpp"

#include <span>

namespace stylet {

struct Pixel {
  double x = 0;
  double y = 0;
  friend bool operator==(const Pixel&, const Pixel&) = default;
};

/// Part of the window, in pixels.
struct Pane {
  double left = 0;
  double top = 0;
  double width = 1;
  double height = 1;
  [[nodiscard]] bool holds(Pixel p) const {
    return p.x >= left && p.x < left + width && p.y >= top && p.y < top + height;
  }
};

class Camera {
 public:
  /// All of these points, two coordinates each, with a margin.
  void fit(std::span<const float> coordinates);
  /// The part of the plane in the middle stays there, and its size too.
  void show_in(const Pane& pane) { pane_ = pane; }
  /// factor > 1: closer. The point under the pixel stays there.
  void zoom(double factor, Pixel at);
  /// What was under the first pixel comes under the second.
  void drag(Pixel from, Pixel to);
  void pan(Vector2 by) { centre_ = centre_ + by; }  ///< m

  [[nodiscard]] const Pane& pane() const { return pane_; }
  [[nodiscard]] Pixel middle() const {
    return {pane_.left + 0.5 * pane_.width, pane_.top + 0.5 * pane_.height};
  }
  [[nodiscard]] double metres_per_pixel() const;
  [[nodiscard]] WorldPoint centre() const { return centre_; }
  [[nodiscard]] Pixel pixel_of(WorldPoint x) const;
  [[nodiscard]] WorldPoint point_at(Pixel p) const;

 private:
  Pane pane_;
  WorldPoint centre_;
  Vector2 extent_{1, 1};  ///< m, that has to fit into the pane
};

}  // namespace stylet
