#include "stylet/needle/earlier_cuts.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet {
namespace {

constexpr double radius = 0.6e-3;

EarlierCuts one_way() {
  return {{{{0, 0, 0}, {0, 0, -0.03}}}, {}};
}

TEST(EarlierCuts, TheSameWayIsFreeAsFarAsItGoes) {
  EXPECT_NEAR(one_way().free_length({0, 0, 0}, {0, 0, -1}, radius), 0.03, 1e-15);
  EXPECT_NEAR(one_way().free_length({0, 0, -0.01}, {0, 0, -1}, radius), 0.02, 1e-15);
  EXPECT_EQ(one_way().free_length({0, 0, -0.03}, {0, 0, -1}, radius), 0);
}

TEST(EarlierCuts, WithinTheRadiusInEveryDirectionAcross) {
  for (int k = 0; k < 12; ++k) {
    const double c = std::cos(0.5 * k);
    const double s = std::sin(0.5 * k);
    const double inside = 0.99 * radius;
    const double outside = 1.01 * radius;
    EXPECT_NEAR(one_way().free_length({inside * c, inside * s, 0}, {0, 0, -1}, radius), 0.03,
                1e-15);
    EXPECT_EQ(one_way().free_length({outside * c, outside * s, 0}, {0, 0, -1}, radius), 0);
  }
}

TEST(EarlierCuts, ANeedleThatCrossesIsFreeWithinTheOtherOne) {
  const double slope = 0.1;
  const double n = std::hypot(1, slope);
  const double free = one_way().free_length({0, 0, -0.01}, {slope / n, 0, -1 / n}, radius);
  EXPECT_NEAR(free, radius * n / slope, 1e-12);
  // Across it, through its middle.
  EXPECT_NEAR(one_way().free_length({0, 0, -0.01}, {0, 1, 0}, radius), radius, 1e-15);
}

TEST(EarlierCuts, WaysThatFollowEachOtherAreOne) {
  const EarlierCuts bent{{{{0, 0, 0}, {0, 0, -0.01}, {0, 0, -0.02}}}, {}};
  EXPECT_NEAR(bent.free_length({0, 0, 0}, {0, 0, -1}, radius), 0.02, 1e-15);
}

}  // namespace
}  // namespace stylet
