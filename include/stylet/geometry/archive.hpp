// Vectors and points in an archive.
#pragma once

#include "stylet/base/archive.hpp"
#include "stylet/geometry/points.hpp"

namespace stylet {

inline void archive(Archive& archive, Vector2& vector) {
  auto& [x, y] = vector;
  archive("x", x);
  archive("y", y);
}

inline void archive(Archive& archive, Vector3& vector) {
  auto& [x, y, z] = vector;
  archive("x", x);
  archive("y", y);
  archive("z", z);
}

template <class Frame>
void archive(Archive& archive, Point<Frame>& point) {
  auto& [x, y] = point;
  archive("x", x);
  archive("y", y);
}

template <class Frame>
void archive(Archive& archive, SpacePoint<Frame>& point) {
  auto& [x, y, z] = point;
  archive("x", x);
  archive("y", y);
  archive("z", z);
}

}  // namespace stylet
