#include "stylet/geometry/tetrahedron_quadrature.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet {
namespace {

double factorial(int n) {
  return std::tgamma(n + 1);
}

// The mean of a monomial of barycentric coordinates is 3! a! b! c! / (a + b + c + 3)!.
TEST(Tetrahedron, FinePointsIntegrateDegreeFive) {
  const auto error = [](int a, int b, int c) {
    double sum = 0;
    for (const auto& [weights, share] : fine_tetrahedron_points()) {
      EXPECT_GT(share, 0);
      for (const double weight : weights) EXPECT_GT(weight, 0);
      sum += share * std::pow(weights[0], a) * std::pow(weights[2], b) * std::pow(weights[3], c);
    }
    return std::abs(sum -
                    6 * factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3));
  };
  for (int a = 0; a <= 5; ++a) {
    for (int b = 0; a + b <= 5; ++b) {
      for (int c = 0; a + b + c <= 5; ++c) EXPECT_LT(error(a, b, c), 1e-15) << a << b << c;
    }
  }
  EXPECT_GT(error(6, 0, 0), 1e-6);
}

}  // namespace
}  // namespace stylet
