// The linear simplex (triangle, tetrahedron): gradients, stiffness and mass, pointwise and free of
// PETSc.
//
// Weak form: sum over cells of  integral( sigma(u) : grad w + rho u'' . w ) = external work,
// sigma = lambda tr(eps) I + 2 mu eps. With constant gradients g_a of the shape functions the block
// of nodes a and b is
//   K_ab = |T| [ lambda g_a (x) g_b + mu ( g_b (x) g_a + (g_a . g_b) I ) ]
//   M_ab = rho |T| (1 + delta_ab) / ((d + 1)(d + 2)) I         (consistent)
//   M_aa = rho |T| / (d + 1) I                                 (row sum)
// In 2D |T| includes the thickness. Source: any text on the finite element method, e.g. Hughes.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace stylet {

/// The two moduli that a linear element needs (Pa). In plane stress lambda is E nu / (1 - nu^2).
struct Moduli {
  double lambda = 0;
  double mu = 0;
};

/// K_ab from the gradients of two shape functions (1/m), constant on a measure.
template <int Dim>
std::array<std::array<double, Dim>, Dim> stiffness_of(const std::array<double, Dim>& a,
                                                      const std::array<double, Dim>& b,
                                                      double measure,
                                                      const Moduli& m) {
  double product = 0;
  for (std::size_t k = 0; k < Dim; ++k) product += a[k] * b[k];
  std::array<std::array<double, Dim>, Dim> block{};
  for (std::size_t i = 0; i < Dim; ++i) {
    for (std::size_t k = 0; k < Dim; ++k) {
      block[i][k] = measure * (m.lambda * a[i] * b[k] + m.mu * b[i] * a[k]);
    }
    block[i][i] += measure * m.mu * product;
  }
  return block;
}

template <int Dim>
struct LinearSimplex {
  static constexpr int n_nodes = Dim + 1;
  using Vector = std::array<double, Dim>;
  using Block = std::array<std::array<double, Dim>, Dim>;

  double measure = 0;                      ///< area or volume (m^2, m^3), signed
  std::array<Vector, n_nodes> gradient{};  ///< of the shape functions (1/m)

  /// x: coordinates of the corners.
  explicit LinearSimplex(const std::array<std::span<const double>, n_nodes>& x) {
    Block jacobian{};  // rows: edges from corner 0
    for (std::size_t i = 0; i < Dim; ++i) {
      for (std::size_t k = 0; k < Dim; ++k) jacobian[i][k] = x[i + 1][k] - x[0][k];
    }
    if constexpr (Dim == 2) {
      const double det = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
      measure = det / 2;
      gradient[1] = {jacobian[1][1] / det, -jacobian[1][0] / det};
      gradient[2] = {-jacobian[0][1] / det, jacobian[0][0] / det};
    } else {
      const auto minor = [&](std::size_t i, std::size_t k) {
        const std::size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (k + 1) % 3, d = (k + 2) % 3;
        return jacobian[a][c] * jacobian[b][d] - jacobian[a][d] * jacobian[b][c];
      };
      const double det = jacobian[0][0] * minor(0, 0) + jacobian[0][1] * minor(0, 1) +
                         jacobian[0][2] * minor(0, 2);
      measure = det / 6;
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) gradient[i + 1][k] = minor(i, k) / det;
      }
    }
    for (std::size_t k = 0; k < Dim; ++k) {
      double sum = 0;
      for (std::size_t i = 1; i < n_nodes; ++i) sum += gradient[i][k];
      gradient[0][k] = -sum;
    }
  }

  /// K_ab per unit thickness.
  [[nodiscard]] Block stiffness(std::size_t a, std::size_t b, const Moduli& m) const {
    return stiffness_of<Dim>(gradient[a], gradient[b], measure, m);
  }

  /// Diagonal value of M_ab per unit density and thickness.
  [[nodiscard]] double consistent_mass(std::size_t a, std::size_t b) const {
    return measure * (a == b ? 2.0 : 1.0) / ((Dim + 1) * (Dim + 2));
  }
  /// The same of every node.
  [[nodiscard]] double lumped_mass(std::size_t /*a*/) const { return measure / (Dim + 1); }

  /// Displacement gradient du_i/dx_k from the corners' displacements.
  [[nodiscard]] Block displacement_gradient(const std::array<Vector, n_nodes>& u) const {
    Block h{};
    for (std::size_t a = 0; a < n_nodes; ++a) {
      for (std::size_t i = 0; i < Dim; ++i) {
        for (std::size_t k = 0; k < Dim; ++k) h[i][k] += u[a][i] * gradient[a][k];
      }
    }
    return h;
  }
};

}  // namespace stylet
