// Where a straight line runs inside tissue in space.
#pragma once

#include "stylet/geometry/points.hpp"
#include "stylet/mesh/mesh.hpp"

#include <optional>

namespace stylet {

/// Of a line, between two distances from its start (m).
struct Stretch {
  double from;
  double to;
  int cell;  ///< that it enters, one of those where several meet there
};

/// The first stretch of a line that lies in the tissue, not before its start; none if it misses. The line
/// may run along faces, edges and through nodes. direction: of unit length. All cells are looked at.
[[nodiscard]] std::optional<Stretch> first_stretch(const Mesh& mesh,
                                                   ReferencePlace start,
                                                   Vector3 direction);

}  // namespace stylet
