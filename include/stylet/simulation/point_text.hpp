// Numbers and points in messages.
#pragma once

#include "stylet/base/text.hpp"
#include "stylet/geometry/rotation.hpp"
#include "stylet/scene/scene.hpp"

#include <cmath>
#include <cstdio>
#include <string>

namespace stylet {

/// Six digits: a measured value for a message.
inline std::string brief(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// A vector or a point of the needle's frame as the scene has it, '(0.08, 0.03)', without what the turn
/// leaves of nothing.
template <class Pair>
std::string pair_text(const Scene& scene, Pair x, double factor = 1) {
  const auto p = Rotation(scene.needle_angle).to_scene(x);
  const double size = std::hypot(p.x, p.y);
  return "(" + brief(factor * cleared(p.x, size)) + ", " + brief(factor * cleared(p.y, size)) + ")";
}

/// The same of a vector (Vector3) or a place, with z in space.
template <class Triple>
std::string vector_text(const Scene& scene, Triple v, double factor = 1) {
  const auto p = Rotation(scene.needle_angle).to_scene(v);
  const double size = std::hypot(std::hypot(p.x, p.y), p.z);
  const auto text = [&](double x) { return brief(factor * cleared(x, size)); };
  return "(" + text(p.x) + ", " + text(p.y) + (scene.dim() == 3 ? ", " + text(p.z) : "") + ")";
}

/// '(0.08, 0.03) m'.
inline std::string point_text(const Scene& scene, ReferencePlace x) {
  return vector_text(scene, x) + " m";
}

}  // namespace stylet
