#include "stylet/study/design.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace stylet {
namespace {

constexpr int n = 20;
constexpr std::size_t d = 3;

TEST(Design, SameSeedSamePoints) {
  EXPECT_EQ(sample(Design::random, n, d, 1), sample(Design::random, n, d, 1));
  EXPECT_NE(sample(Design::random, n, d, 1), sample(Design::random, n, d, 2));
}

TEST(Design, LatinHypercubeHasOnePointInEveryStratum) {
  const auto points = sample(Design::latin_hypercube, n, d, 1);
  ASSERT_EQ(points.size(), std::size_t{n});
  for (std::size_t j = 0; j < d; ++j) {
    std::set<int> strata;
    for (const auto& point : points) strata.insert(static_cast<int>(point[j] * n));
    EXPECT_EQ(strata.size(), std::size_t{n});
  }
}

TEST(Design, MorrisChangesEveryVariableOnceByTwoThirds) {
  const auto points = sample(Design::morris, n, d, 1);
  ASSERT_EQ(points.size(), n * (d + 1));
  for (std::size_t first = 0; first < points.size(); first += d + 1) {
    std::set<std::size_t> changed;
    for (std::size_t i = first; i < first + d; ++i) {
      for (std::size_t j = 0; j < d; ++j) {
        EXPECT_GE(points[i + 1][j], -1e-12);
        EXPECT_LE(points[i + 1][j], 1 + 1e-12);
        if (points[i][j] == points[i + 1][j]) continue;
        EXPECT_NEAR(std::abs(points[i + 1][j] - points[i][j]), 2.0 / 3, 1e-12);
        EXPECT_TRUE(changed.insert(j).second);
      }
    }
    EXPECT_EQ(changed.size(), d);
  }
}

TEST(Design, SaltelliExchangesOneColumn) {
  const auto points = sample(Design::sobol, n, d, 1);
  ASSERT_EQ(points.size(), n * (d + 2));
  for (std::size_t j = 0; j < d; ++j) {
    for (std::size_t i = 0; i < n; ++i) {
      const auto& mixed = points[(2 + j) * n + i];
      for (std::size_t k = 0; k < d; ++k) EXPECT_EQ(mixed[k], points[(k == j ? n : 0) + i][k]);
    }
  }
}

}  // namespace
}  // namespace stylet
