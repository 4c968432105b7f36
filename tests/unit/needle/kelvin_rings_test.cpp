#include "stylet/needle/kelvin_rings.hpp"

#include "stylet/base/errors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace stylet {
namespace {

constexpr double pi = std::numbers::pi;

TEST(KelvinRings, PrintedDigits) {
  struct Known {
    double s, a, b, along, across, digits;
  };
  // By another program, which agrees with quadrature.
  for (const auto& known : {Known{1, 1, 1, 0.04003062, 0.03344869, 1e-8},
                            {0.5, 2, 2, 0.02971992, 0.03090279, 1e-8},
                            {1.5, 1, 3, 0.0155050456, 0.0172552352, 1e-10}}) {
    const RingMeans means = ring_means(known.s, known.a, known.b);
    EXPECT_NEAR(kelvin_along(means, 1, 0.45), known.along, 0.51 * known.digits);
    EXPECT_NEAR(kelvin_across(means, 1, 0.45), known.across, 0.51 * known.digits);
  }
}

// Kelvin's solution itself, point by point. The sum over equal angles converges faster than any power.
TEST(KelvinRings, AreMeansOfKelvinsSolution) {
  constexpr double g = 2;
  constexpr double nu = 0.3;
  constexpr double a = 0.7;
  constexpr double b = 1.9;
  constexpr double s = -0.8;
  constexpr int n = 200;
  double along = 0;
  double across = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double from = 2 * pi * i / n;
      const double to = 2 * pi * j / n;
      const double x = a * std::cos(from) - b * std::cos(to);
      const double y = a * std::sin(from) - b * std::sin(to);
      const double r = std::sqrt(x * x + y * y + s * s);
      const double factor = 1 / (16 * pi * g * (1 - nu) * r * n * n);
      along += factor * (3 - 4 * nu + s * s / (r * r));
      across += factor * (3 - 4 * nu + x * x / (r * r));
    }
  }
  const RingMeans means = ring_means(s, a, b);
  EXPECT_NEAR(kelvin_along(means, g, nu), along, 1e-14);
  EXPECT_NEAR(kelvin_across(means, g, nu), across, 1e-14);
}

// f(t) = t^k over the disc, t = (radius / 10)^2.
TEST(KelvinRings, RingsOfADiscAreGaussPoints) {
  for (const int n : {1, 2, 5, 8, 10}) {
    const auto rings = disc_rings(10, n);
    ASSERT_EQ(static_cast<int>(rings.size()), n);
    for (int k = 0; k < 2 * n; ++k) {
      double sum = 0;
      for (const auto& [radius, weight] : rings) sum += weight * std::pow(radius / 10, 2 * k);
      EXPECT_NEAR(sum, 1.0 / (k + 1), 1e-15) << n << " " << k;
    }
    for (int i = 1; i < n; ++i) {
      EXPECT_LT(rings[static_cast<std::size_t>(i) - 1].radius,
                rings[static_cast<std::size_t>(i)].radius);
    }
  }
}

TEST(KelvinRings, ADiscMovesLikeARing) {
  EXPECT_NEAR(effective_radius(disc_rings(10, 4)), 7.70921, 5e-6);
  EXPECT_NEAR(effective_radius(disc_rings(10, 10)), 7.77350, 5e-6);
  EXPECT_NEAR(effective_radius(disc_rings(10, 200)), 10 * std::exp(-0.25), 1e-4);
}

TEST(KelvinRings, AKernelIsTheNeedleItselfOrMovesLikeAWiderOne) {
  for (const double narrow : {0.3e-3, 0.635e-3}) {
    const auto rings = kernel_rings(narrow, 0.635e-3, 8);
    ASSERT_EQ(rings.size(), 1u);
    EXPECT_EQ(rings[0].radius, 0.635e-3);
    EXPECT_EQ(rings[0].weight, 1);
  }
  EXPECT_EQ(kernel_rings(0.82e-3, 0.635e-3, 8).size(), 8u);
  try {
    (void)kernel_rings(0.8e-3, 0.635e-3, 8);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_STREQ(
        e.what(),
        "a kernel_radius of 0.8 mm moves like a needle of 0.621271 mm, which is not wider than "
        "the needle's own radius of 0.635 mm: take at least 0.817679 mm, or no more than the "
        "needle's own radius");
  }
}

}  // namespace
}  // namespace stylet
