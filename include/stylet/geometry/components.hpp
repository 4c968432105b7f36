// Vectors and points as a scene has them, whose dimension only the run knows.
#pragma once

#include "stylet/geometry/points.hpp"

#include <optional>

namespace stylet {

/// Two components in the plane, three in space.
struct Components {
  double x = 0;
  double y = 0;
  std::optional<double> z = {};

  Components() = default;
  Components(double x_, double y_, std::optional<double> z_ = {}) : x(x_), y(y_), z(z_) {}
  Components(Vector2 v) : x(v.x), y(v.y) {}         // NOLINT: the same in the plane
  Components(ReferencePoint p) : x(p.x), y(p.y) {}  // NOLINT

  [[nodiscard]] int dim() const { return z ? 3 : 2; }
  [[nodiscard]] Vector3 vector() const { return {x, y, z.value_or(0)}; }
  [[nodiscard]] ReferencePlace place() const { return {x, y, z.value_or(0)}; }
  friend bool operator==(const Components&, const Components&) = default;
};

inline double component(Vector3 v, std::size_t k) {
  return k == 0 ? v.x : k == 1 ? v.y : v.z;
}

}  // namespace stylet
