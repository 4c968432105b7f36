// A smooth displacement on the unit square, held at its boundary, with the body force that it needs:
// order 2 in the L2 norm and order 1 in the energy norm.
#include "stylet/dynamics/quasi_static.hpp"
#include "stylet/fem/material.hpp"

#include "support/body.hpp"
#include <gtest/gtest.h>

#include <numbers>

namespace stylet {
namespace {

constexpr double pi = std::numbers::pi;
constexpr LinearElastic elastic{2.5, 0.3, 0};

// u = (sin(pi x) sin(pi y), sin(2 pi x) sin(pi y)).
Vector2 exact(ReferencePoint p) {
  return {std::sin(pi * p.x) * std::sin(pi * p.y), std::sin(2 * pi * p.x) * std::sin(pi * p.y)};
}

LinearSimplex<2>::Block exact_gradient(ReferencePoint p) {
  return {
      {{pi * std::cos(pi * p.x) * std::sin(pi * p.y), pi * std::sin(pi * p.x) * std::cos(pi * p.y)},
       {2 * pi * std::cos(2 * pi * p.x) * std::sin(pi * p.y),
        pi * std::sin(2 * pi * p.x) * std::cos(pi * p.y)}}};
}

// f = -(lambda + mu) grad div u - mu laplace u.
Vector2 body_force(ReferencePoint p, const Moduli& m) {
  const Vector2 u = exact(p);
  const double xx1 = -pi * pi * u.x;
  const double yy1 = -pi * pi * u.x;
  const double xx2 = -4 * pi * pi * u.y;
  const double yy2 = -pi * pi * u.y;
  const double xy1 = pi * pi * std::cos(pi * p.x) * std::cos(pi * p.y);
  const double xy2 = 2 * pi * pi * std::cos(2 * pi * p.x) * std::cos(pi * p.y);
  return {-(m.lambda + m.mu) * (xx1 + xy2) - m.mu * (xx1 + yy1),
          -(m.lambda + m.mu) * (xy1 + yy2) - m.mu * (xx2 + yy2)};
}

struct QuadraturePoint {
  std::array<double, 3> at;
  double weight;
};

// Six points, exact for polynomials of degree 4 (Dunavant 1985).
std::vector<QuadraturePoint> quadrature() {
  std::vector<QuadraturePoint> points;
  const auto add = [&](double a, double weight) {
    for (std::size_t i = 0; i < 3; ++i) {
      QuadraturePoint q{{a, a, a}, weight};
      q.at[i] = 1 - 2 * a;
      points.push_back(q);
    }
  };
  add(0.445948490915965, 0.223381589678011);
  add(0.091576213509771, 0.109951743655322);
  return points;
}

template <class Each>
void integrate(const Mesh& mesh, Each&& each) {
  static const auto points = quadrature();
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto n = mesh.cell(c);
    for (const auto& q : points) {
      ReferencePoint p{0, 0};
      for (std::size_t i = 0; i < 3; ++i) {
        p.x += q.at[i] * mesh.point(n[i]).x;
        p.y += q.at[i] * mesh.point(n[i]).y;
      }
      each(c, p, q.at, q.weight * mesh.cell_measure(c));
    }
  }
}

double energy_density(const LinearSimplex<2>::Block& h, const Moduli& m) {
  const double trace = h[0][0] + h[1][1];
  return 0.5 * m.lambda * trace * trace + shear_energy_density(h, m.mu);
}

struct Errors {
  double l2 = 0;
  double energy = 0;
};

Errors solve(int n, Plane plane, Diagonals diagonals) {
  Slab body(rectangle({.columns = n, .rows = n, .jitter = 0.15, .diagonals = diagonals}),
            material(elastic, plane));
  const Mesh& mesh = body.mesh;
  const Moduli m = moduli_of(elastic, plane);
  std::vector<double> force(static_cast<std::size_t>(body.tissue.n_dofs()), 0.0);
  integrate(mesh, [&](int c, ReferencePoint p, const std::array<double, 3>& at, double weight) {
    const Vector2 f = body_force(p, m);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto node = static_cast<std::size_t>(mesh.cell(c)[i]);
      force[2 * node] += weight * at[i] * f.x;
      force[2 * node + 1] += weight * at[i] * f.y;
    }
  });
  const OwnedVec load = vector_of(body.tissue, force);
  QuasiStatic integrator(body.tissue, body.mesh);
  State state = still(body.tissue);
  take_step(integrator, state, load.get(), 1,
            held(dofs_of(mesh, {"left", "right", "bottom", "top"})));
  const auto u = gather_all(state.u.get());
  Errors errors;
  integrate(mesh, [&](int c, ReferencePoint p, const std::array<double, 3>& at, double weight) {
    const auto nodes = mesh.cell(c);
    std::array<LinearSimplex<2>::Vector, 3> corner{};
    Vector2 value;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto node = static_cast<std::size_t>(nodes[i]);
      corner[i] = {u[2 * node], u[2 * node + 1]};
      value = value + at[i] * Vector2{corner[i][0], corner[i][1]};
    }
    const Vector2 off = value - exact(p);
    errors.l2 += weight * dot(off, off);
    const LinearSimplex<2> element(
        {mesh.coordinates(nodes[0]), mesh.coordinates(nodes[1]), mesh.coordinates(nodes[2])});
    auto gradient = element.displacement_gradient(corner);
    const auto wanted = exact_gradient(p);
    for (std::size_t i = 0; i < 2; ++i) {
      for (std::size_t k = 0; k < 2; ++k) gradient[i][k] -= wanted[i][k];
    }
    errors.energy += weight * energy_density(gradient, m);
  });
  return {std::sqrt(errors.l2), std::sqrt(errors.energy)};
}

using Case = std::pair<Plane, Diagonals>;
class Manufactured : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Meshes,
                         Manufactured,
                         testing::Values(Case{Plane::stress, Diagonals::alternating},
                                         Case{Plane::strain, Diagonals::one_way}));

TEST_P(Manufactured, OrderIsTwoInL2AndOneInEnergy) {
  const auto [plane, diagonals] = GetParam();
  const Errors coarse = solve(32, plane, diagonals);
  const Errors fine = solve(64, plane, diagonals);
  const double l2 = order(coarse.l2, fine.l2);
  const double energy = order(coarse.energy, fine.energy);
  RecordProperty("l2", std::to_string(l2));
  RecordProperty("energy", std::to_string(energy));
  // Jittered meshes of two sizes are not nested, hence the last per cent.
  EXPECT_NEAR(l2, 2, 0.06);
  EXPECT_NEAR(energy, 1, 0.03);
}

}  // namespace
}  // namespace stylet
