// Measures of a tetrahedron. Corners are right-handed: seen from the last one, the first three run
// counter-clockwise.
#pragma once

#include "stylet/geometry/points.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace stylet {

template <class Frame>
using Tetrahedron = std::array<SpacePoint<Frame>, 4>;

template <class Frame>
double signed_volume(const Tetrahedron<Frame>& t) {
  return dot(t[1] - t[0], cross(t[2] - t[0], t[3] - t[0])) / 6;
}

/// The mean ratio, 12 (3 V)^(2/3) / (sum of squared edges): 1 for the regular tetrahedron, 0 for a
/// degenerate one, negative when inverted. Source: Liu and Joe, BIT 34 (1994) 268.
template <class Frame>
double quality(const Tetrahedron<Frame>& t) {
  double edges = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j) edges += dot(t[i] - t[j], t[i] - t[j]);
  }
  const double root = std::cbrt(3 * signed_volume(t));
  return edges > 0 ? std::copysign(12 * root * root / edges, root) : 0.0;
}

/// Barycentric coordinates of four points that integrate quadratics exactly with weights that are alike.
/// Source: Keast, Comput. Methods Appl. Mech. Engng 55 (1986) 339.
inline const std::array<std::array<double, 4>, 4>& tetrahedron_points() {
  static const std::array<std::array<double, 4>, 4> points = [] {
    const double root = std::sqrt(5.0);
    std::array<std::array<double, 4>, 4> all{};
    for (std::size_t q = 0; q < 4; ++q) {
      all[q].fill((5 - root) / 20);
      all[q][q] = (5 + 3 * root) / 20;
    }
    return all;
  }();
  return points;
}

/// Barycentric coordinates of p (sum 1; all non-negative inside).
template <class Frame>
std::array<double, 4> barycentric(const Tetrahedron<Frame>& t, SpacePoint<Frame> p) {
  const double volume = signed_volume(t);
  std::array<double, 4> weights{};
  double rest = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    Tetrahedron<Frame> part = t;
    part[i] = p;
    weights[i] = signed_volume(part) / volume;
    rest -= weights[i];
  }
  weights[3] = rest;
  return weights;
}

}  // namespace stylet
