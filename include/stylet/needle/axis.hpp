// The straight line that the needle moves along. Needle code speaks of along and across, never of x
// and y.
#pragma once

#include "stylet/geometry/points.hpp"

namespace stylet {

/// The needle enters from the right and advances towards -x at the height `across_position`.
struct Axis {
  double across_position = 0;  ///< m

  static constexpr int along_component = 0;
  static constexpr int across_component = 1;
  static constexpr double along_sign = -1;

  /// Unit vector of advance.
  [[nodiscard]] static Vector2 direction() { return {along_sign, 0}; }
  /// Component in the direction of advance.
  [[nodiscard]] static double along(Vector2 v) { return along_sign * v.x; }
  [[nodiscard]] static double across(Vector2 v) { return v.y; }
  template <class Frame>
  [[nodiscard]] static double along(Point<Frame> p) {
    return along_sign * p.x;
  }
  template <class Frame>
  [[nodiscard]] static double across(Point<Frame> p) {
    return p.y;
  }
  /// The point of the axis at an along coordinate.
  template <class Frame>
  [[nodiscard]] Point<Frame> at(double along_position) const {
    return {along_sign * along_position, across_position};
  }
  [[nodiscard]] static int along_dof(int node) { return 2 * node + along_component; }
  [[nodiscard]] static int across_dof(int node) { return 2 * node + across_component; }
};

}  // namespace stylet
