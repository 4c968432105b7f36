// A line in the middle of the unit square (plane strain, E = 1, nu = 0.3): the shape of a needle in
// tissue, from x = 1/2 to the free side. Values of a high-order computation.
#include "support/body.hpp"
#include "support/scenes.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

Scene square(int n, const std::string& diagonals, const std::vector<std::string>& more) {
  std::vector<std::string> overrides{"mesh.rectangle.columns=" + std::to_string(n),
                                     "mesh.rectangle.rows=" + std::to_string(n),
                                     "mesh.rectangle.diagonals=" + diagonals};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return scene_of(R"(
mesh:
  rectangle:
    size: [1 m, 1 m]
    columns: 2
    rows: 2
    curves: [{name: line, points: [[0.5 m, 0.5 m], [1 m, 0.5 m]]}]
tissue:
  plane: strain
  thickness: 1 m
  formulation: p1
  regions: {tissue: {youngs_modulus: 1 Pa, poisson_ratio: 0.3, density: 1 kg/m^3}}
supports: {left: fixed, top: fixed, bottom: fixed}
probes: {tip: [0.5 m, 0.5 m]}
time: {method: quasi_static, step: 1 s}
)",
                  overrides);
}

// B: the line moved by (-1, 0). Its ends are singular like a square root, so the order is one.
double stuck_force(int n, const std::string& diagonals) {
  Simulation simulation(
      MPI_COMM_WORLD,
      square(n, diagonals, {"prescribed=[{curve: line, displacement: [-1 m, 0 m]}]"}), false);
  run_to_end(simulation);
  const Vector3 force = simulation.body().curve_reaction(0);
  // The other component vanishes by symmetry of the problem, though not of the mesh.
  EXPECT_LT(std::abs(force.y), 0.02 * std::abs(force.x));
  return -force.x;
}

// C: pulled by a total of -1 along the line, no displacement across it. With the force given the
// singularity is of its gradient only and logarithmic: order two but for the logarithm.
double tip_displacement(int n, const std::string& diagonals) {
  Simulation simulation(MPI_COMM_WORLD,
                        square(n, diagonals,
                               {"prescribed=[{curve: line, displacement: [null, 0 m]}]",
                                "loads.traction=[{curve: line, force: [-2 N/m, 0 N/m]}]"}),
                        false);
  run_to_end(simulation);
  return simulation.body().world(simulation.probes())[0].x - 0.5;
}

struct Study {
  double order;
  double limit;  ///< extrapolated with the order seen
  double finest;
};

template <class Quantity>
Study study(Quantity&& quantity) {
  const double a = quantity(32);
  const double b = quantity(64);
  const double c = quantity(128);
  const double ratio = (a - b) / (b - c);
  return {std::log2(ratio), c + (c - b) / (ratio - 1), c};
}

void record(const Study& s) {
  testing::Test::RecordProperty("order", std::to_string(s.order));
  testing::Test::RecordProperty("limit", std::to_string(s.limit));
  testing::Test::RecordProperty("finest", std::to_string(s.finest));
}

class RigidLine : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Diagonals, RigidLine, testing::Values("one_way", "alternating"));

TEST_P(RigidLine, StuckNeedleNeedsTheKnownForce) {
  const Study s = study([](int n) { return stuck_force(n, GetParam()); });
  record(s);
  constexpr double exact = 1.3689;
  EXPECT_GT(s.finest, exact);  // too stiff
  EXPECT_NEAR(s.finest, exact, 0.01 * exact);
  EXPECT_NEAR(s.order, 1, 0.15);
  // The order that is seen differs from 1 because of the next term of the error.
  EXPECT_NEAR(s.limit, exact, 0.001 * exact);
}

TEST_P(RigidLine, SlidingNeedleMovesAsKnown) {
  const Study s = study([](int n) { return tip_displacement(n, GetParam()); });
  record(s);
  constexpr double exact = -0.515506;
  EXPECT_GT(s.order, 1.7);
  EXPECT_LT(s.order, 2.1);
  EXPECT_NEAR(s.finest, exact, 5e-4 * -exact);
  // What the logarithm leaves in the extrapolated value.
  EXPECT_NEAR(s.limit, exact, 5e-5 * -exact);
}

}  // namespace
}  // namespace stylet
