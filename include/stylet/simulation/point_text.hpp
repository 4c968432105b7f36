// Numbers and points in messages.
#pragma once

#include "stylet/geometry/rotation.hpp"
#include "stylet/scene/scene.hpp"

#include <cstdio>
#include <string>

namespace stylet {

/// Six digits: a measured value for a message.
inline std::string brief(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// A point as the scene has it: '(0.08, 0.03) m'.
inline std::string point_text(const Scene& scene, ReferencePoint x) {
  const auto p = Rotation(scene.needle_angle).to_scene(x);
  return "(" + brief(p.x) + ", " + brief(p.y) + ") m";
}

}  // namespace stylet
