// A picture that looks like ultrasound: speckle whose grain and brightness differ by region, a bright
// capsule, less echo with the distance from the probe at the lower edge.
#pragma once

#include "stylet/image/picture.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace stylet {

/// What the beams meet, pixel by pixel.
struct Echoes {
  static constexpr int nothing = -1;
  Picture frame;                        ///< its size and place; no bytes
  std::vector<int> region;              ///< row by row from the top
  std::vector<ReferencePoint> capsule;  ///< closed polygon in the scene's frame; empty: none
};

/// Regions that a triangle of the scene's frame covers.
void cover(Echoes& echoes, ReferencePoint a, ReferencePoint b, ReferencePoint c, int region);

/// The same bytes on any machine: hashed integers, sums, products and square roots only. seed: of the
/// speckle; attenuation: in 1/m.
[[nodiscard]] Picture ultrasound(const Echoes& echoes, std::uint32_t seed, double attenuation);

}  // namespace stylet
