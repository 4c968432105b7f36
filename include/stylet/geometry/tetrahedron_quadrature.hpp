// Quadrature in a tetrahedron, finer than that of its stiffness (tetrahedron.hpp).
#pragma once

#include <array>
#include <cstddef>

namespace stylet {

struct TetrahedronPoint {
  std::array<double, 4> weights;  ///< barycentric coordinates
  double share;                   ///< of the volume
};

/// Fourteen points that integrate polynomials of degree five exactly, all shares positive.
/// Source: Walkington, Quadrature on Simplices of Arbitrary Dimension, Carnegie Mellon University, 2000.
inline const std::array<TetrahedronPoint, 14>& fine_tetrahedron_points() {
  static const std::array<TetrahedronPoint, 14> points = [] {
    std::array<TetrahedronPoint, 14> all{};
    std::size_t n = 0;
    const auto add_corners = [&](double a, double share) {
      for (std::size_t i = 0; i < 4; ++i) {
        all[n].share = share;
        all[n].weights.fill(a);
        all[n++].weights[i] = 1 - 3 * a;
      }
    };
    add_corners(0.31088591926330060980, 0.11268792571801585080);
    add_corners(0.092735250310891226402, 0.073493043116361949544);
    constexpr double b = 0.045503704125649649492;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = i + 1; k < 4; ++k) {
        all[n].share = 0.042546020777081466438;
        all[n].weights.fill(b);
        all[n].weights[i] = all[n].weights[k] = 0.5 - b;
        ++n;
      }
    }
    return all;
  }();
  return points;
}

}  // namespace stylet
