// The explicit step's one pass over triangles against the same step with K of the tissue operator.
#include "stylet/dynamics/explicit_step.hpp"

#include "support/body.hpp"
#include "support/edits.hpp"
#include <gtest/gtest.h>

#include <random>

namespace stylet {
namespace {

// Sums of a few dozen products of numbers with 16 digits, relative to the largest.
constexpr double round_off = 1e-12;

struct Case {
  Formulation formulation;
  double stiffness_factor;  ///< s
};

class ExplicitStep : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Cases,
                         ExplicitStep,
                         testing::Values(Case{Formulation::p1, 0},
                                         Case{Formulation::p1, 1e-4},
                                         Case{Formulation::p1_averaged, 0},
                                         Case{Formulation::p1_averaged, 1e-4}));

// Two regions of unlike moduli; ten blocks of nodes.
Slab two_regions(Formulation formulation) {
  RectangleMesh p;
  p.width = 0.08;
  p.height = 0.06;
  p.columns = 40;
  p.rows = 30;
  p.jitter = 0.25;
  p.inner_regions = {{"core", Ellipse{{0.045, 0.03}, 0.02, 0.015}}};
  auto parameters =
      material({60e3, 0.45, 1000}, Plane::strain, MassKind::lumped, 0.01, formulation);
  parameters.regions.push_back({"core", {9e3, 0.49, 1100}});
  return {make_rectangle(p), parameters, [](int) { return true; }};
}

/// A step of random fields from start to end.
struct Fields {
  explicit Fields(const Slab& body, double stiffness_factor)
      : tissue(body.tissue), factors{1e-4, 150, stiffness_factor} {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(-1, 1);
    for (auto& field : start) {
      for (int dof = 0; dof < tissue.n_dofs(); ++dof) field.push_back(any(random));
    }
    for (auto& field : end) field.resize(start[0].size());
    const auto masses = gather_all(tissue.lumped_mass());
    for (std::size_t dof = 0; dof < masses.size(); dof += 2) {
      mass.push_back(masses[dof]);
      inverse_root.push_back(1 / std::sqrt(masses[dof]));
    }
    for (const std::size_t dof : {3UL, 4UL, 700UL, start[0].size() - 1}) {
      given.push_back({dof, any(random)});
    }
  }
  ExplicitArrays arrays() {
    double* const stretched = factors.stiffness_factor != 0 ? end[3].data() : end[0].data();
    return {mass.size(),   start[0].data(), start[1].data(), start[2].data(),
            end[0].data(), end[1].data(),   end[2].data(),   stretched,
            end[2].data(), start[3].data(), mass.data(),     inverse_root.data()};
  }
  const TissueOperator& tissue;
  ExplicitFactors factors;
  std::vector<double> start[4];  ///< u, v, a, load
  std::vector<double> end[4];    ///< u, v, a, stretched
  std::vector<double> mass;
  std::vector<double> inverse_root;
  std::vector<GivenPlace> given;
};

void expect_same_step(const Slab& body, const CellKernel& cells, double stiffness_factor) {
  Fields by_rows(body, stiffness_factor);
  StepSums expected;
  predict(by_rows.arrays(), by_rows.factors, by_rows.given, expected);
  auto& [u, v, a, s] = by_rows.end;
  const OwnedVec vec = vector_of(body.tissue, stiffness_factor != 0 ? s : u);
  const auto force = product(body.tissue, body.tissue.stiffness(), vec.get());
  for (std::size_t i = 0; i < force.size(); ++i) {
    const auto [h, mass_factor, unused] = by_rows.factors;
    const double load = by_rows.start[3][i];
    expected.load += load * v[i];
    expected.rest += (load - force[i]) * v[i];
    a[i] = ((load - force[i]) / by_rows.mass[i / 2] - mass_factor * v[i]) /
           (1 + 0.5 * h * mass_factor);
    v[i] += 0.5 * h * a[i];
  }
  for (const auto& [dof, value] : by_rows.given) EXPECT_EQ(u[dof], value);

  Fields by_cells(body, stiffness_factor);
  StepSums sums;
  std::vector<double> pressure;
  step(by_cells.arrays(), by_cells.factors, cells, by_cells.given, pressure, sums);
  for (std::size_t field = 0; field < 4; ++field) {
    const double size = largest(by_rows.end[field]);
    double worst = 0;
    for (std::size_t i = 0; i < force.size(); ++i) {
      worst = std::max(worst, std::abs(by_cells.end[field][i] - by_rows.end[field][i]));
    }
    EXPECT_LE(worst, round_off * size) << "field " << field;
  }
  EXPECT_NEAR(sums.start, expected.start, round_off * expected.half);
  EXPECT_NEAR(sums.half, expected.half, round_off * expected.half);
  EXPECT_NEAR(sums.blow, expected.blow, round_off * expected.half);
  const double power = largest(force) * largest(by_rows.end[1]) * std::sqrt(force.size());
  EXPECT_NEAR(sums.load, expected.load, round_off * power);
  EXPECT_NEAR(sums.rest, expected.rest, round_off * power);
}

TEST_P(ExplicitStep, TrianglesGiveWhatRowsGive) {
  const Slab body = two_regions(GetParam().formulation);
  const CellKernel cells(body.mesh, body.tissue);
  ASSERT_GE(cells.n_blocks(), 8U);
  expect_same_step(body, cells, GetParam().stiffness_factor);
}

TEST_P(ExplicitStep, FollowsMovedNodesAndFlippedEdges) {
  Slab body = two_regions(GetParam().formulation);
  CellKernel cells(body.mesh, body.tissue);
  std::mt19937 random(7);
  for (int round = 0; round < 4; ++round) {
    const auto moved = move_nodes(body.mesh, random);
    body.tissue.update(body.mesh, moved);
    ASSERT_TRUE(cells.update(body.mesh, body.tissue, moved));
    expect_same_step(body, cells, GetParam().stiffness_factor);
    const auto flipped = flip_edges(body.mesh);
    EXPECT_GT(flipped.size(), 100U);
    body.tissue.update(body.mesh, flipped);
    ASSERT_TRUE(cells.update(body.mesh, body.tissue, flipped));
    expect_same_step(body, cells, GetParam().stiffness_factor);
  }
}

}  // namespace
}  // namespace stylet
