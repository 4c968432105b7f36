// Patch test in space: a linear displacement is an exact solution on any mesh of tetrahedra.
#include "stylet/fem/material.hpp"
#include "stylet/fem/simplex.hpp"

#include "support/solid.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

constexpr LinearElastic elastic{60e3, 0.45, 1000};
// Displacement gradient of the field; entries of different size and sign.
constexpr double h[3][3] = {{1e-2, 2e-2, -1e-2}, {-3e-2, 5e-3, 4e-3}, {7e-3, -2e-3, 2e-2}};
// Sums of about ten products of numbers with 16 digits.
constexpr double round_off = 1e-12;

Vector3 linear_field(ReferencePlace x) {
  const auto row = [&](std::size_t i) { return h[i][0] * x.x + h[i][1] * x.y + h[i][2] * x.z; };
  return {3e-4 + row(0), -2e-4 + row(1), 1e-4 + row(2)};
}

// Hooke's law in E and nu.
Stress exact_stress() {
  const double e = elastic.youngs_modulus;
  const double nu = elastic.poisson_ratio;
  const double factor = e / ((1 + nu) * (1 - 2 * nu));
  const double trace = h[0][0] + h[1][1] + h[2][2];
  const auto normal = [&](std::size_t i) { return factor * ((1 - 2 * nu) * h[i][i] + nu * trace); };
  const auto shear = [&](std::size_t i, std::size_t k) {
    return e / (2 * (1 + nu)) * (h[i][k] + h[k][i]);
  };
  return {normal(0), normal(1), shear(0, 1), normal(2), shear(1, 2), shear(2, 0)};
}

class SpacePatch : public testing::TestWithParam<Formulation> {
 protected:
  SpacePatch() : body(bricks({0.08, 0.06, 0.04}, {5, 4, 3}, 0.25), solid(elastic, GetParam())) {}
  Slab body;
};
INSTANTIATE_TEST_SUITE_P(
    Kinds, SpacePatch, testing::Values(Formulation::p1, Formulation::p1_averaged, Formulation::p2));

TEST_P(SpacePatch, LinearFieldLeavesNoForceInside) {
  const OwnedVec u = nodal_in_space(body.tissue, body.mesh, linear_field);
  const auto force = product(body.tissue, body.tissue.stiffness(), u.get());
  const Stress s = exact_stress();
  const double stress[3][3] = {{s.xx, s.xy, s.zx}, {s.xy, s.yy, s.yz}, {s.zx, s.yz, s.zz}};
  double moment[3][3] = {};
  for (int node = 0; node < body.mesh.n_nodes(); ++node) {
    const auto x = body.mesh.coordinates(node);
    for (std::size_t i = 0; i < 3; ++i) {
      const double f = force[3 * static_cast<std::size_t>(node) + i];
      if (!body.mesh.on_boundary(node)) {
        EXPECT_NEAR(f, 0, round_off * largest(force)) << node;
      }
      for (std::size_t k = 0; k < 3; ++k) moment[i][k] += f * x[k];
    }
  }
  // Virtual work of the linear fields: sum of f (x) x = stress times volume.
  const double volume = 0.08 * 0.06 * 0.04;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(moment[i][k], stress[i][k] * volume, round_off * std::abs(s.xx) * volume);
    }
  }
}

TEST_P(SpacePatch, DisplacementsOfTheBoundaryGiveTheFieldInside) {
  const auto exact = gather_all(nodal_in_space(body.tissue, body.mesh, linear_field).get());
  ConstraintSet boundary;
  for (int node = 0; node < body.mesh.n_nodes(); ++node) {
    if (!body.mesh.on_boundary(node)) continue;
    for (int k = 0; k < 3; ++k) {
      const int dof = 3 * node + k;
      boundary.dofs.push_back({dof, exact[static_cast<std::size_t>(dof)]});
    }
  }
  const auto u = at_rest(body, std::vector<double>(exact.size(), 0.0), boundary);
  for (std::size_t i = 0; i < u.size(); ++i) {
    EXPECT_NEAR(u[i], exact[i], round_off * largest(exact));
  }
}

TEST_P(SpacePatch, StressIsConstantAndEnergyThatOfTheStiffness) {
  const OwnedVec vec = nodal_in_space(body.tissue, body.mesh, linear_field);
  const auto u = gather_all(vec.get());
  const Stress exact = exact_stress();
  const double tolerance = round_off * std::abs(exact.xx) * 10;
  double energy = 0;
  PatchPressures known;
  for (int c = 0; c < body.mesh.n_cells(); ++c) {
    const auto gradient = gradient_at(body.mesh, c, {0.1, 0.2, 0.3, 0.4}, u);
    const double mu = body.tissue.moduli(c).mu;
    const VolumetricState volume = body.tissue.volumetric(body.mesh, c, u, known);
    const Stress s = space_stress(gradient, mu, volume.pressure);
    EXPECT_NEAR(s.xx, exact.xx, tolerance);
    EXPECT_NEAR(s.yy, exact.yy, tolerance);
    EXPECT_NEAR(s.zz, exact.zz, tolerance);
    EXPECT_NEAR(s.xy, exact.xy, tolerance);
    EXPECT_NEAR(s.yz, exact.yz, tolerance);
    EXPECT_NEAR(s.zx, exact.zx, tolerance);
    energy +=
        body.mesh.cell_measure(c) * (volume.energy_density + shear_energy_density(gradient, mu));
  }
  const auto force = product(body.tissue, body.tissue.stiffness(), vec.get());
  double work = 0;
  for (std::size_t i = 0; i < u.size(); ++i) work += 0.5 * u[i] * force[i];
  EXPECT_NEAR(energy, work, 10 * round_off * work);
}

TEST_P(SpacePatch, EnergyOfAnyFieldIsThatOfTheStiffness) {
  const OwnedVec vec = nodal_in_space(body.tissue, body.mesh, [](ReferencePlace x) {
    return Vector3{x.x * x.y - 0.05 * x.z, x.y * x.y + 0.3 * x.x * x.z, x.z * x.z - x.x * x.x};
  });
  const auto u = gather_all(vec.get());
  double energy = 0;
  PatchPressures known;
  for (int c = 0; c < body.mesh.n_cells(); ++c) {
    double density = body.tissue.volumetric(body.mesh, c, u, known).energy_density;
    for (const auto& point : tetrahedron_points()) {
      density +=
          shear_energy_density(gradient_at(body.mesh, c, point, u), body.tissue.moduli(c).mu) / 4;
    }
    energy += density * body.mesh.cell_measure(c);
  }
  const auto force = product(body.tissue, body.tissue.stiffness(), vec.get());
  double work = 0;
  for (std::size_t i = 0; i < u.size(); ++i) work += 0.5 * u[i] * force[i];
  EXPECT_NEAR(energy, work, round_off * work);
}

TEST_P(SpacePatch, RigidMotionsAreForceFree) {
  const auto force_of = [&](const auto& field) {
    return largest(product(body.tissue, body.tissue.stiffness(),
                           nodal_in_space(body.tissue, body.mesh, field).get()));
  };
  const double strained = force_of(linear_field);
  const auto turn = [](ReferencePlace x) {
    return cross(Vector3{0.01, -0.02, 0.015}, x - ReferencePlace{});
  };
  EXPECT_LT(force_of([](ReferencePlace) {
              return Vector3{0.01, -0.02, 0.03};
            }),
            10 * round_off * strained);
  EXPECT_LT(force_of(turn), 10 * round_off * strained);
}

// Its forces are those of the constant body force that it needs, so both are exact.
TEST(QuadraticPatch, AQuadraticFieldIsExact) {
  Slab body(bricks({0.08, 0.06, 0.04}, {3, 3, 2}, 0.25), solid(elastic, Formulation::p2));
  const auto field = [](ReferencePlace x) {
    return Vector3{x.x * x.y - 0.5 * x.z * x.z, x.y * x.y + 0.3 * x.x * x.z, x.z * x.z - x.x * x.x};
  };
  // -div sigma = -(lambda + mu) grad div u - mu (sum of second derivatives)
  const Moduli m = lame_moduli(elastic);
  const Vector3 f = (-(m.lambda + m.mu)) * Vector3{0, 3, 2} + (-m.mu) * Vector3{-1, 2, 0};
  const auto exact = gather_all(nodal_in_space(body.tissue, body.mesh, field).get());
  std::vector<double> force(exact.size());
  for (int c = 0; c < body.mesh.n_cells(); ++c) {
    for (std::size_t k = 0; k < 10; ++k) {
      const double share = body.mesh.cell_measure(c) * (k < 4 ? -1.0 / 20 : 1.0 / 5);
      double* of_node = &force[3 * static_cast<std::size_t>(body.mesh.nodes(c)[k])];
      for (std::size_t i = 0; i < 3; ++i) of_node[i] += share * std::array{f.x, f.y, f.z}[i];
    }
  }
  ConstraintSet boundary;
  for (int dof = 0; dof < body.tissue.n_dofs(); ++dof) {
    if (!body.mesh.on_boundary(dof / 3)) continue;
    boundary.dofs.push_back({dof, exact[static_cast<std::size_t>(dof)]});
  }
  ASSERT_LT(boundary.dofs.size(), exact.size());
  const auto u = at_rest(body, force, boundary);
  for (std::size_t i = 0; i < u.size(); ++i) {
    EXPECT_NEAR(u[i], exact[i], round_off * largest(exact));
  }
}

TEST_P(SpacePatch, MassIsThatOfTheVolume) {
  for (const MassKind kind : {MassKind::consistent, MassKind::lumped}) {
    const Slab other(bricks({0.08, 0.06, 0.04}, {5, 4, 3}, 0.25), solid(elastic, GetParam(), kind));
    const OwnedVec ones = nodal_in_space(other.tissue, other.mesh, [](ReferencePlace) {
      return Vector3{1, 0, 0};
    });
    OwnedVec product = other.tissue.make_vector();
    other.tissue.apply_mass(ones.get(), product.get());
    PetscScalar mass = 0;
    check(VecDot(ones.get(), product.get(), &mass));
    EXPECT_NEAR(mass, 1000 * 0.08 * 0.06 * 0.04, round_off);
  }
}

}  // namespace
}  // namespace stylet
