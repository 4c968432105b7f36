// The quadratic tetrahedron with straight sides: stiffness and masses, pointwise and free of PETSc.
//
// Shape functions of the barycentric coordinates L: L_a (2 L_a - 1) at corners, 4 L_a L_b in the middle of
// edges. Their gradients are linear, so K is exact at the four points of Keast, Comput. Methods Appl.
// Mech. Engng 55 (1986) 339. The consistent mass is integrated in closed form; the lumped one is its
// diagonal scaled to the cell's mass (Hinton, Rock and Zienkiewicz, Earthq. Engng Struct. Dyn. 4 (1976)
// 245): row sums of corners would be negative.
#pragma once

#include "stylet/fem/element.hpp"
#include "stylet/geometry/tetrahedron.hpp"
#include "stylet/mesh/quadratic.hpp"

#include <array>
#include <cstddef>

namespace stylet {

struct QuadraticTetrahedron {
  static constexpr std::size_t n_nodes = 10;
  using Vector = LinearSimplex<3>::Vector;
  using Block = LinearSimplex<3>::Block;
  using Gradients = std::array<Vector, n_nodes>;

  LinearSimplex<3> corners;
  std::array<Gradients, 4> at_points{};  ///< of the shape functions at the quadrature points (1/m)

  explicit QuadraticTetrahedron(const LinearSimplex<3>& linear) : corners(linear) {
    for (std::size_t q = 0; q < 4; ++q) at_points[q] = gradients(tetrahedron_points()[q]);
  }

  /// Of the shape functions at a point with these barycentric coordinates (1/m).
  [[nodiscard]] Gradients gradients(const std::array<double, 4>& l) const {
    Gradients g{};
    const auto& of_corner = corners.gradient;
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t a = 0; a < 4; ++a) g[a][k] = (4 * l[a] - 1) * of_corner[a][k];
      for (std::size_t e = 0; e < 6; ++e) {
        const auto [a, b] = tetrahedron_edges[e];
        g[4 + e][k] = 4 * (l[a] * of_corner[b][k] + l[b] * of_corner[a][k]);
      }
    }
    return g;
  }

  /// K_ab.
  [[nodiscard]] Block stiffness(std::size_t a, std::size_t b, const Moduli& m) const {
    Block sum{};
    for (const Gradients& g : at_points) {
      const Block block = stiffness_of<3>(g[a], g[b], corners.measure / 4, m);
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) sum[i][k] += block[i][k];
      }
    }
    return sum;
  }

  /// Diagonal value of M_ab per unit density.
  [[nodiscard]] double consistent_mass(std::size_t a, std::size_t b) const {
    return corners.measure / 420 * product(a, b);
  }
  /// Of node a, per unit density.
  [[nodiscard]] double lumped_mass(std::size_t a) const {
    return corners.measure * (a < 4 ? 1.0 / 36 : 4.0 / 27);
  }

 private:
  // 420 times the mean of N_a N_b.
  static double product(std::size_t a, std::size_t b) {
    if (a > b) return product(b, a);
    if (b < 4) return a == b ? 6 : 1;
    const auto& [p, q] = tetrahedron_edges[b - 4];
    if (a < 4) return a == p || a == q ? -4 : -6;
    const int shared = int{is_of_edge(a - 4, p)} + int{is_of_edge(a - 4, q)};
    constexpr std::array<double, 3> of_shared{8, 16, 32};
    return of_shared[static_cast<std::size_t>(shared)];
  }
};

}  // namespace stylet
