// The linear tetrahedron on a cube of twelve around an inner node.
#include "stylet/fem/element.hpp"
#include "stylet/fem/material.hpp"
#include "stylet/fem/quadratic_tetrahedron.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace stylet {
namespace {

using Vector3 = LinearSimplex<3>::Vector;
using Tetrahedron = std::array<std::size_t, 4>;

constexpr std::size_t centre = 8;
// Sums of about ten products of numbers with 16 digits.
constexpr double round_off = 1e-13;

// Corner i of the unit cube has the binary digits of i as coordinates; corners shifted a little so
// that no two tetrahedra are alike.
std::vector<Vector3> nodes() {
  std::vector<Vector3> x;
  for (int i = 0; i < 8; ++i) {
    x.push_back(
        {(i & 1) + 0.01 * i, ((i >> 1) & 1) - 0.02 * (i % 3), ((i >> 2) & 1) + 0.015 * (i % 5)});
  }
  x.push_back({0.42, 0.55, 0.47});
  return x;
}

LinearSimplex<3> element(const std::vector<Vector3>& x, const Tetrahedron& t) {
  return LinearSimplex<3>({x[t[0]], x[t[1]], x[t[2]], x[t[3]]});
}

// Each face of the cube cut in two, joined to the centre; right-handed.
std::vector<Tetrahedron> tetrahedra(const std::vector<Vector3>& x) {
  const std::array<std::array<std::size_t, 4>, 6> faces = {
      {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}}};
  std::vector<Tetrahedron> cells;
  for (const auto& f : faces) {
    for (Tetrahedron t : {Tetrahedron{f[0], f[1], f[2], centre}, {f[0], f[2], f[3], centre}}) {
      if (element(x, t).measure < 0) std::swap(t[0], t[1]);
      cells.push_back(t);
    }
  }
  return cells;
}

constexpr LinearElastic elastic{60e3, 0.4, 1000};

std::vector<Vector3> forces(const std::vector<Vector3>& x, const std::vector<Vector3>& u) {
  std::vector<Vector3> f(x.size(), Vector3{});
  for (const auto& t : tetrahedra(x)) {
    const auto e = element(x, t);
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        const auto block = e.stiffness(a, b, lame_moduli(elastic));
        for (std::size_t i = 0; i < 3; ++i) {
          for (std::size_t k = 0; k < 3; ++k) f[t[a]][i] += block[i][k] * u[t[b]][k];
        }
      }
    }
  }
  return f;
}

constexpr std::array<Vector3, 3> h = {
    {{1e-2, 2e-2, -1e-2}, {-3e-2, 5e-3, 4e-3}, {7e-3, -2e-3, 2e-2}}};

std::vector<Vector3> linear_field(const std::vector<Vector3>& x,
                                  const std::array<Vector3, 3>& gradient) {
  std::vector<Vector3> u(x.size(), Vector3{0.1, -0.2, 0.3});
  for (std::size_t n = 0; n < x.size(); ++n) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) u[n][i] += gradient[i][k] * x[n][k];
    }
  }
  return u;
}

double largest(const std::vector<Vector3>& f) {
  double size = 0;
  for (const auto& v : f) {
    for (const double value : v) size = std::max(size, std::abs(value));
  }
  return size;
}

TEST(Tetrahedron, LinearFieldLeavesNoForceAtTheInnerNode) {
  const auto x = nodes();
  const auto f = forces(x, linear_field(x, h));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(f[centre][i], 0, round_off * largest(f) * 10);
}

TEST(Tetrahedron, WorkOfALinearFieldIsItsStrainEnergy) {
  const auto x = nodes();
  const auto u = linear_field(x, h);
  const auto f = forces(x, u);
  double work = 0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    for (std::size_t i = 0; i < 3; ++i) work += 0.5 * f[n][i] * u[n][i];
  }
  const auto m = lame_moduli(elastic);
  double trace = 0;
  double squares = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    trace += h[i][i];
    for (std::size_t k = 0; k < 3; ++k) squares += std::pow(0.5 * (h[i][k] + h[k][i]), 2);
  }
  double volume = 0;
  for (const auto& t : tetrahedra(x)) volume += element(x, t).measure;
  const double exact = (0.5 * m.lambda * trace * trace + m.mu * squares) * volume;
  // The offset of the field costs two digits.
  EXPECT_NEAR(work, exact, 1e3 * round_off * exact);
}

TEST(Tetrahedron, RigidMotionsAreForceFree) {
  const auto x = nodes();
  const double strained = largest(forces(x, linear_field(x, h)));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<Vector3, 3> turn{};
    turn[(axis + 1) % 3][(axis + 2) % 3] = -0.02;
    turn[(axis + 2) % 3][(axis + 1) % 3] = 0.02;
    EXPECT_LT(largest(forces(x, linear_field(x, turn))), 100 * round_off * strained);
  }
  EXPECT_LT(largest(forces(x, linear_field(x, {}))), 100 * round_off * strained);
}

TEST(Tetrahedron, MassAddsUpToTheVolume) {
  const auto x = nodes();
  for (const auto& t : tetrahedra(x)) {
    const auto e = element(x, t);
    double sum = 0;
    for (std::size_t a = 0; a < 4; ++a) {
      double row = 0;
      for (std::size_t b = 0; b < 4; ++b) row += e.consistent_mass(a, b);
      EXPECT_NEAR(row, e.lumped_mass(a), round_off * e.measure);
      sum += row;
    }
    EXPECT_NEAR(sum, e.measure, round_off * e.measure);
  }
}

// int L_a^i L_b^j ... = 6 V i! j! ... / (3 + i + j + ...)!
TEST(QuadraticTetrahedron, MassesAreThoseOfItsShapeFunctions) {
  const auto x = nodes();
  const auto linear = element(x, tetrahedra(x)[0]);
  const QuadraticTetrahedron e(linear);
  const double tolerance = round_off * linear.measure;
  double lumped = 0;
  for (std::size_t a = 0; a < 10; ++a) {
    double row = 0;
    for (std::size_t b = 0; b < 10; ++b) row += e.consistent_mass(a, b);
    EXPECT_NEAR(row, linear.measure * (a < 4 ? -1.0 / 20 : 1.0 / 5), tolerance);
    EXPECT_GT(e.lumped_mass(a), 0);
    EXPECT_NEAR(e.lumped_mass(a) / e.consistent_mass(a, a),
                e.lumped_mass(0) / e.consistent_mass(0, 0), 1e-12);
    lumped += e.lumped_mass(a);
  }
  EXPECT_NEAR(lumped, linear.measure, tolerance);
  // Nodal values of L_0 L_1 (0 at corners, 1/4 in the middle of its edge) and of L_2^2.
  const auto product = [&](const auto& u, const auto& v) {
    double sum = 0;
    for (std::size_t a = 0; a < 10; ++a) {
      for (std::size_t b = 0; b < 10; ++b) sum += u[a] * e.consistent_mass(a, b) * v[b];
    }
    return sum;
  };
  std::array<double, 10> bubble{};
  std::array<double, 10> square{};
  bubble[4] = 0.25;
  square[2] = 1;
  for (std::size_t edge = 0; edge < 6; ++edge) {
    if (is_of_edge(edge, 2)) square[4 + edge] = 0.25;
  }
  EXPECT_NEAR(product(bubble, bubble), 6 * linear.measure * 4 / 5040, tolerance);
  EXPECT_NEAR(product(bubble, square), 6 * linear.measure * 2 / 5040, tolerance);
  EXPECT_NEAR(product(square, square), 6 * linear.measure * 24 / 5040, tolerance);
}

TEST(Tetrahedron, GradientsBelongToTheHatFunctions) {
  const auto x = nodes();
  for (const auto& t : tetrahedra(x)) {
    const auto e = element(x, t);
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        double change = 0;  // of hat function a from corner 0 to corner b
        for (std::size_t k = 0; k < 3; ++k) change += e.gradient[a][k] * (x[t[b]][k] - x[t[0]][k]);
        const double exact = (a == b ? 1.0 : 0.0) - (a == 0 ? 1.0 : 0.0);
        EXPECT_NEAR(change, exact, 10 * round_off);
      }
    }
  }
}

}  // namespace
}  // namespace stylet
