// What earlier needles have cut: a path that was cut stays cut, for every needle that comes along it.
#pragma once

#include "stylet/geometry/points.hpp"

#include <span>
#include <vector>

namespace stylet {

/// The reference frame is the material's: these points stay where they are when the mesh is rewritten.
struct EarlierCuts {
  std::vector<std::vector<ReferencePlace>> paths;  ///< from the skin to the deepest point
  std::vector<ReferencePlace> punctures;           ///< of the membrane

  /// How far along the unit vector r from p tissue is cut already (m): as far as the ray stays within
  /// `radius` of a path and does not pass its end.
  [[nodiscard]] double free_length(ReferencePlace p, Vector3 r, double radius) const;
};

/// True if p is within `radius` of one of the points.
[[nodiscard]] bool is_near(std::span<const ReferencePlace> points, ReferencePlace p, double radius);

}  // namespace stylet
