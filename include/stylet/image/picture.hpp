// A picture of the tissue before anything moves, and its place.
#pragma once

#include "stylet/geometry/points.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stylet {

struct Picture {
  int width = 0;  ///< pixels
  int height = 0;
  int channels = 1;                 ///< 1: grey; 3: red, green, blue
  std::vector<std::uint8_t> bytes;  ///< row by row from the top, without padding
  // Its rectangle, in the scene's frame of the undeformed tissue (m).
  ReferencePoint origin;  ///< lower left corner
  Vector2 size;

  [[nodiscard]] const std::uint8_t* pixel(int column, int row) const {
    const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(column);
    return bytes.data() + at * static_cast<std::size_t>(channels);
  }
  /// Place of a point of the scene's frame: 0, 0 at the upper left corner, 1, 1 at the lower right one.
  [[nodiscard]] Vector2 texture_at(ReferencePoint x) const {
    return {(x.x - origin.x) / size.x, 1 - (x.y - origin.y) / size.y};
  }
};

}  // namespace stylet
