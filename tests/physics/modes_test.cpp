// Natural frequencies of squares with E = rho = 1 and nu = 0.3 in plane strain, against known values.
#include "stylet/solvers/modes.hpp"

#include "stylet/simulation/model.hpp"

#include "support/body.hpp"
#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace stylet {
namespace {

// The three lowest on n x n squares.
std::vector<double> frequencies(int n,
                                const std::string& supports,
                                const std::string& mass,
                                const std::string& diagonals) {
  const Scene scene = scene_of(
      R"(
mesh: {rectangle: {size: [1 m, 1 m], columns: 1, rows: 1}}
tissue:
  plane: strain
  thickness: 1 m
  regions: {tissue: {youngs_modulus: 1 Pa, poisson_ratio: 0.3, density: 1 kg/m^3}}
time: {method: implicit, duration: 1 s}
)",
      {"mesh.rectangle.columns=" + std::to_string(n), "mesh.rectangle.rows=" + std::to_string(n),
       "mesh.rectangle.diagonals=" + diagonals, "tissue.mass=" + mass, "supports=" + supports});
  NumberedMesh numbered = make_mesh(MPI_COMM_WORLD, scene);
  check_against_mesh(scene, numbered.mesh);
  const auto tissue = make_tissue(MPI_COMM_WORLD, scene, numbered);
  std::vector<int> held_dofs;
  for (const auto& c : Conditions(scene, numbered.mesh).prescribed(0)) held_dofs.push_back(c.dof);
  return natural_frequencies(*tissue, held_dofs, 3);
}

const std::string rollers = "{left: roller, right: roller, bottom: roller, top: roller}";
const std::string clamps = "{left: fixed, bottom: fixed, top: fixed}";

// c_s pi sqrt(2), then c_p pi twice: (1, 0) and (0, 1).
std::vector<double> exact_rollers() {
  const double mu = 1 / (2 * 1.3);
  const double p_modulus = 0.7 / (1.3 * 0.4);
  const double pi = std::numbers::pi;
  return {std::sqrt(2 * mu) * pi, std::sqrt(p_modulus) * pi, std::sqrt(p_modulus) * pi};
}

class BoxModes : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Diagonals, BoxModes, testing::Values("one_way", "alternating"));

TEST_P(BoxModes, ConsistentMassConvergesFromAboveWithOrderTwo) {
  const auto exact = exact_rollers();
  EXPECT_NEAR(exact[0], 2.7553590, 1e-7);
  EXPECT_NEAR(exact[1], 3.6449974, 1e-7);
  const auto coarse = frequencies(16, rollers, "consistent", GetParam());
  const auto fine = frequencies(32, rollers, "consistent", GetParam());
  for (std::size_t i = 0; i < 3; ++i) {
    // A subspace of the displacements cannot give less than the exact Rayleigh quotient.
    EXPECT_GT(fine[i], exact[i]);
    EXPECT_NEAR(order(coarse[i] - exact[i], fine[i] - exact[i]), 2, 0.05) << "mode " << i;
    // A share of (k h)^2, which is 0.02 with k h = pi sqrt(2) / 32.
    EXPECT_NEAR(fine[i], exact[i], 4e-3 * exact[i]) << "mode " << i;
  }
}

TEST_P(BoxModes, LumpedMassConvergesWithOrderTwo) {
  const auto exact = exact_rollers();
  const auto coarse = frequencies(16, rollers, "lumped", GetParam());
  const auto fine = frequencies(32, rollers, "lumped", GetParam());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(fine[i], exact[i], 4e-3 * exact[i]) << "mode " << i;
    EXPECT_NEAR(order(coarse[i] - exact[i], fine[i] - exact[i]), 2, 0.1) << "mode " << i;
  }
}

TEST(ClampedSquare, FirstFrequenciesAreThoseOfAHighOrderComputation) {
  const std::vector<double> exact{2.491907, 3.492991, 3.642831};
  const auto coarse = frequencies(32, clamps, "consistent", "alternating");
  const auto fine = frequencies(64, clamps, "consistent", "alternating");
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GT(fine[i], exact[i]);
    // The corners between held and free sides (singular) lower the order below 2.
    const double seen = order(coarse[i] - exact[i], fine[i] - exact[i]);
    EXPECT_GT(seen, 1.3) << "mode " << i;
    EXPECT_LT(seen, 2.1) << "mode " << i;
    EXPECT_NEAR(fine[i], exact[i], 2e-3 * exact[i]) << "mode " << i;
    RecordProperty("order_" + std::to_string(i), std::to_string(seen));
  }
}

TEST(FreeSquare, HasThreeRigidModesWithFrequencyZero) {
  const auto found = frequencies(8, "{left: free}", "consistent", "alternating");
  // Square roots of round-off of omega^2, which is 1e-16 times its largest value of about 1e3.
  for (const double omega : found) EXPECT_LT(omega, 1e-5);
}

}  // namespace
}  // namespace stylet
