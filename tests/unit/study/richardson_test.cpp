#include "stylet/study/richardson.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace stylet {
namespace {

// NASA's worked example (NPARC alliance, Examining Spatial Grid Convergence): pressure recovery on
// three grids, ratio 2. Printed with five to six digits.
TEST(Richardson, NasaExample) {
  const std::vector<double> recovery{0.96178, 0.96854, 0.97050};
  const auto result = extrapolate(recovery, 2, 2);
  EXPECT_NEAR(result.order, 1.78618, 2e-5);  // from the values as printed
  EXPECT_NEAR(result.limit, 0.971300, 1e-6);
  EXPECT_EQ(result.safety, 1.25);
  EXPECT_NEAR(100 * result.uncertainty[2] / recovery[2], 0.103080, 1e-5);
  // Its index of the middle grid scales the last change; ours is the distance to the limit itself.
  const double middle = 1.25 * 0.00676 / (std::pow(2, 1.78618) - 1);
  EXPECT_NEAR(100 * middle / recovery[1], 0.356244, 1e-4);
  EXPECT_NEAR(result.uncertainty[1], middle, 1e-6);
}

TEST(Richardson, FitFindsExactOrder) {
  std::vector<double> values;
  for (const double h : {8.0, 4.0, 2.0, 1.0}) values.push_back(3 + 0.1 * std::pow(h, 1.5));
  const auto result = extrapolate(values, 2, 2);
  EXPECT_NEAR(result.order, 1.5, 0.005);  // the spacing of the search
  EXPECT_NEAR(result.limit, 3, 1e-3);
  EXPECT_NEAR(result.uncertainty.back(), 0.125, 2e-3);
}

TEST(Richardson, ValuesWithoutOrderAreTreatedWithCare) {
  const auto wavering = extrapolate(std::vector{1.0, 1.2, 1.1}, 2, 2);
  EXPECT_EQ(wavering.safety, 3);
  EXPECT_TRUE(std::isnan(wavering.order));
  EXPECT_EQ(wavering.limit, 1.1);
  EXPECT_NEAR(wavering.uncertainty[2], 0.3, 1e-12);
  EXPECT_GE(wavering.uncertainty[0], 0.3);
  EXPECT_FALSE(wavering.remark.empty());

  const auto diverging = extrapolate(std::vector{1.0, 1.1, 1.3}, 2, 2);
  EXPECT_EQ(diverging.safety, 3);
  EXPECT_LT(diverging.order, 0);
  EXPECT_NEAR(diverging.uncertainty[2], 0.6, 1e-12);

  const auto two = extrapolate(std::vector{1.0, 1.1}, 2, 2);
  EXPECT_NEAR(two.uncertainty[1], 0.3, 1e-12);

  const auto constant = extrapolate(std::vector{2.0, 2.0, 2.0}, 2, 2);
  EXPECT_EQ(constant.uncertainty[2], 0);
  EXPECT_EQ(constant.limit, 2);
}

// Faster than the scheme can be: an accident, so the formal order is used.
TEST(Richardson, TooHighOrder) {
  const auto result = extrapolate(std::vector{1.0, 1.16, 1.17}, 2, 2);
  EXPECT_NEAR(result.order, 4, 1e-9);
  EXPECT_EQ(result.safety, 3);
  EXPECT_NEAR(result.uncertainty[2], 0.01, 1e-12);
}

}  // namespace
}  // namespace stylet
