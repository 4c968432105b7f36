// Cook's membrane in plane strain, nu = 0.3, p1: a tapered plate held on the left under shear.
#include "benchmarks.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

TEST(Cook, DisplacementsConvergeToAHighOrderComputation) {
  constexpr double middle = 21.9450;
  constexpr double corner = 23.0567;
  const auto solve = [](int n) {
    return benchmark::cook_displacements(benchmark::cook(n, Diagonals::alternating), 0.3,
                                         Formulation::p1);
  };
  const auto coarse = solve(32);
  const auto fine = solve(64);
  // Too stiff, as linear triangles are.
  EXPECT_LT(fine.middle, middle);
  EXPECT_LT(fine.corner, corner);
  // The held side ends in a singular corner; at the loaded side's own corner the traction does not
  // fit the free top, which costs more.
  const double order_middle = order(middle - coarse.middle, middle - fine.middle);
  const double order_corner = order(corner - coarse.corner, corner - fine.corner);
  EXPECT_GT(order_middle, 1.5);
  EXPECT_LT(order_middle, 2.1);
  EXPECT_GT(order_corner, 1.1);
  EXPECT_LT(order_corner, 2.1);
  EXPECT_NEAR(fine.middle, middle, 0.005 * middle);
  EXPECT_NEAR(fine.corner, corner, 0.01 * corner);
  RecordProperty("middle", std::to_string(fine.middle));
  RecordProperty("corner", std::to_string(fine.corner));
  RecordProperty("order_middle", std::to_string(order_middle));
  RecordProperty("order_corner", std::to_string(order_corner));
}

}  // namespace
}  // namespace stylet
