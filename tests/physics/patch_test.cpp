// Patch test: a linear displacement is an exact solution on any mesh, and stays one after edits.
#include "stylet/fem/material.hpp"

#include "support/body.hpp"
#include "support/edits.hpp"
#include <gtest/gtest.h>

#include <random>

namespace stylet {
namespace {

constexpr LinearElastic elastic{60e3, 0.45, 1000};
// Displacement gradient of the field; entries of different size and sign.
constexpr double h_xx = 1e-2, h_xy = 2e-2, h_yx = -3e-2, h_yy = 5e-3;
// Sums of about ten products of numbers with 16 digits.
constexpr double round_off = 1e-12;

Vector2 linear_field(ReferencePoint x) {
  return {3e-4 + h_xx * x.x + h_xy * x.y, -2e-4 + h_yx * x.x + h_yy * x.y};
}

// Stress by the textbook formulas in E and nu.
Stress exact_stress(Plane plane) {
  const double e = elastic.youngs_modulus;
  const double nu = elastic.poisson_ratio;
  const double shear = e / (2 * (1 + nu)) * (h_xy + h_yx);
  if (plane == Plane::stress) {
    const double factor = e / (1 - nu * nu);
    return {factor * (h_xx + nu * h_yy), factor * (h_yy + nu * h_xx), shear, 0};
  }
  const double factor = e / ((1 + nu) * (1 - 2 * nu));
  return {factor * ((1 - nu) * h_xx + nu * h_yy), factor * ((1 - nu) * h_yy + nu * h_xx), shear,
          factor * nu * (h_xx + h_yy)};
}

void expect_patch_test(const Slab& body, Plane plane) {
  const OwnedVec u = nodal(body.tissue, body.mesh, linear_field);
  const auto force = product(body.tissue, body.tissue.stiffness(), u.get());
  const double size = largest(force);
  const Stress stress = exact_stress(plane);
  double moment[2][2] = {};
  for (int node = 0; node < body.mesh.n_nodes(); ++node) {
    const auto x = body.mesh.coordinates(node);
    for (std::size_t i = 0; i < 2; ++i) {
      const double f = force[2 * static_cast<std::size_t>(node) + i];
      if (!body.mesh.on_boundary(node)) {
        EXPECT_NEAR(f, 0, round_off * size) << "node " << node;
      }
      for (std::size_t k = 0; k < 2; ++k) moment[i][k] += f * x[k];
    }
  }
  // Virtual work of the linear fields: sum of f (x) x = stress times volume.
  double volume = 0;
  for (int c = 0; c < body.mesh.n_cells(); ++c) volume += body.mesh.cell_measure(c);
  volume *= body.tissue.parameters().thickness;
  const double scale = std::abs(stress.xx) * volume;
  EXPECT_NEAR(moment[0][0], stress.xx * volume, round_off * scale);
  EXPECT_NEAR(moment[1][1], stress.yy * volume, round_off * scale);
  EXPECT_NEAR(moment[0][1], stress.xy * volume, round_off * scale);
  EXPECT_NEAR(moment[1][0], stress.xy * volume, round_off * scale);
}

struct Kind {
  Plane plane;
  Formulation formulation;
};

Slab jittered(Kind kind, std::function<bool(int)> needs_flips = {}) {
  return {rectangle({.width = 0.08, .height = 0.06, .columns = 9, .rows = 7, .jitter = 0.25}),
          material(elastic, kind.plane, MassKind::consistent, 0.01, kind.formulation),
          std::move(needs_flips)};
}

class Patch : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Kinds,
                         Patch,
                         testing::Values(Kind{Plane::stress, Formulation::p1},
                                         Kind{Plane::strain, Formulation::p1},
                                         Kind{Plane::stress, Formulation::p1_averaged},
                                         Kind{Plane::strain, Formulation::p1_averaged}));

TEST_P(Patch, LinearFieldIsExactOnAJitteredMesh) {
  expect_patch_test(jittered(GetParam()), GetParam().plane);
}

TEST_P(Patch, StressOfALinearFieldIsConstant) {
  const Slab body = jittered(GetParam());
  const Stress exact = exact_stress(GetParam().plane);
  const auto all = gather_all(nodal(body.tissue, body.mesh, linear_field).get());
  const double tolerance = round_off * std::abs(exact.xx);
  PatchPressures known;
  for (int c = 0; c < body.mesh.n_cells(); ++c) {
    const auto n = body.mesh.cell(c);
    const auto at = [&](std::size_t i) { return body.mesh.coordinates(n[i]); };
    const auto u = [&](std::size_t i) {
      const Vector2 value = linear_field(body.mesh.point(n[i]));
      return LinearSimplex<2>::Vector{value.x, value.y};
    };
    const LinearSimplex<2> element({at(0), at(1), at(2)});
    const auto s =
        plane_stress(element.displacement_gradient({u(0), u(1), u(2)}), body.tissue.moduli(c).mu,
                     body.tissue.volumetric(body.mesh, c, all, known).pressure, GetParam().plane);
    EXPECT_NEAR(s.xx, exact.xx, tolerance);
    EXPECT_NEAR(s.yy, exact.yy, tolerance);
    EXPECT_NEAR(s.xy, exact.xy, tolerance);
    EXPECT_NEAR(s.zz, exact.zz, tolerance);
  }
}

TEST_P(Patch, EnergyOfCellsIsThatOfTheStiffness) {
  const Slab body = jittered(GetParam());
  const OwnedVec u = nodal(body.tissue, body.mesh, [](ReferencePoint x) {
    return Vector2{x.x * x.y - 0.05 * x.x, x.y * x.y + 0.3 * x.x * x.x};
  });
  const auto all = gather_all(u.get());
  const auto force = product(body.tissue, body.tissue.stiffness(), u.get());
  double work = 0;
  for (std::size_t i = 0; i < all.size(); ++i) work += 0.5 * all[i] * force[i];
  double energy = 0;
  PatchPressures known;
  for (int c = 0; c < body.mesh.n_cells(); ++c) {
    const auto n = body.mesh.cell(c);
    const auto at = [&](std::size_t i) { return body.mesh.coordinates(n[i]); };
    const auto corner = [&](std::size_t i) {
      const auto dof = 2 * static_cast<std::size_t>(n[i]);
      return LinearSimplex<2>::Vector{all[dof], all[dof + 1]};
    };
    const LinearSimplex<2> element({at(0), at(1), at(2)});
    const auto h = element.displacement_gradient({corner(0), corner(1), corner(2)});
    energy += (body.tissue.volumetric(body.mesh, c, all, known).energy_density +
               shear_energy_density(h, body.tissue.moduli(c).mu)) *
              element.measure * body.tissue.parameters().thickness;
  }
  EXPECT_NEAR(energy, work, round_off * work);
}

TEST_P(Patch, RigidMotionsAreForceFree) {
  const Slab body = jittered(GetParam());
  const auto strained = product(body.tissue, body.tissue.stiffness(),
                                nodal(body.tissue, body.mesh, linear_field).get());
  const auto shift = [](ReferencePoint) { return Vector2{0.01, -0.02}; };
  const auto turn = [](ReferencePoint x) { return Vector2{-0.02 * x.y, 0.02 * x.x}; };
  EXPECT_LT(largest(product(body.tissue, body.tissue.stiffness(),
                            nodal(body.tissue, body.mesh, shift).get())),
            round_off * largest(strained));
  EXPECT_LT(largest(product(body.tissue, body.tissue.stiffness(),
                            nodal(body.tissue, body.mesh, turn).get())),
            round_off * largest(strained));
}

double difference(Mat a, Mat b) {
  OwnedMat rest;
  check(MatDuplicate(a, MAT_COPY_VALUES, rest.put()));
  check(MatAXPY(rest.get(), -1, b, DIFFERENT_NONZERO_PATTERN));
  PetscReal size = 0;
  check(MatNorm(rest.get(), NORM_FROBENIUS, &size));
  return size;
}

// room: whether the pattern has room for flips or is made anew.
void expect_patch_test_after_edits(Kind kind, bool room) {
  Slab body = jittered(kind, room ? [](int) { return true; } : std::function<bool(int)>{});
  const std::size_t n_cells = static_cast<std::size_t>(body.mesh.n_cells());
  std::mt19937 random(7);
  for (int round = 0; round < 3; ++round) {
    body.tissue.update(body.mesh, move_nodes(body.mesh, random));
    expect_patch_test(body, kind.plane);
    const auto flipped = flip_edges(body.mesh);
    EXPECT_GT(flipped.size(), n_cells / 10);
    body.tissue.update(body.mesh, flipped);
    expect_patch_test(body, kind.plane);
    // Rows are sums in the order of cells, so a row made anew has the bits of a fresh operator.
    const TissueOperator fresh(MPI_COMM_WORLD, body.mesh, {0, body.mesh.n_nodes()},
                               body.tissue.parameters());
    EXPECT_EQ(difference(fresh.stiffness(), body.tissue.stiffness()), 0);
    EXPECT_EQ(difference(fresh.mass(), body.tissue.mass()), 0);
  }
}

TEST_P(Patch, HoldsAfterMovedNodesAndFlippedEdges) {
  expect_patch_test_after_edits(GetParam(), true);
}

TEST_P(Patch, HoldsAfterFlipsThatThePatternHasNoRoomFor) {
  expect_patch_test_after_edits(GetParam(), false);
}

}  // namespace
}  // namespace stylet
