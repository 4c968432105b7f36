#include "stylet/needle/rest_compliance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace stylet {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double radius = 0.635;  // mm, and G = 1 N/mm^2

TrackSegment segment(double from, double nu = 0.45, double g = 1) {
  return {from, from + 1, g, nu};
}

RestCompliance far_from_skin(double kernel, int rings, double length) {
  return {radius, kernel_rings(kernel, radius, rings), length, false};
}

TEST(RestCompliance, PrintedDigits) {
  const auto c = far_from_skin(10, 4, 400);
  EXPECT_NEAR(c.along(segment(0), segment(0)), 0.077774, 6e-7);
  EXPECT_NEAR(c.along(segment(0), segment(1)), 0.046937, 6e-7);
  EXPECT_NEAR(c.along(segment(0), segment(5)), 0.009398, 6e-7);
  EXPECT_NEAR(c.along(segment(0), segment(20)), 0.000660, 6e-7);
  EXPECT_NEAR(c.across(segment(0), segment(0)), 0.075456, 6e-7);
  double along = 0;
  double across = 0;
  for (int j = 0; j < 400; ++j) {
    along += c.along(segment(200), segment(j));
    across += c.across(segment(200), segment(j));
  }
  EXPECT_NEAR(along, 0.397150, 6e-7);
  EXPECT_NEAR(across, 0.216721, 6e-7);
}

// An endless needle in the plane across it; what 400 mm leave out falls off with the square of their length.
TEST(RestCompliance, RowsOfALongNeedleSumToALogarithm) {
  const auto rings = kernel_rings(10, radius, 8);
  const RestCompliance c(radius, rings, 1600, false);
  double along = 0;
  double across = 0;
  for (int j = 0; j < 1600; ++j) {
    along += c.along(segment(800, 0.3, 2), segment(j, 0.3, 2));
    across += c.across(segment(800, 0.3, 2), segment(j, 0.3, 2));
  }
  const double log_ratio = std::log(effective_radius(rings) / radius);
  EXPECT_NEAR(along / (log_ratio / (4 * pi)), 1, 5e-5);
  EXPECT_NEAR(across / ((3 - 1.2) * log_ratio / (16 * pi * 0.7)), 1, 5e-5);
}

/// Cholesky's factor of C - shift exists.
bool is_above(double shift, const std::vector<std::vector<double>>& c) {
  std::vector<std::vector<double>> l = c;
  for (std::size_t i = 0; i < l.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = c[i][j] - (i == j ? shift : 0);
      for (std::size_t k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
      if (i == j && sum <= 0) return false;
      l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
    }
  }
  return true;
}

using Entry = double (RestCompliance::*)(const TrackSegment&, const TrackSegment&) const;

std::vector<std::vector<double>> matrix(const RestCompliance& c,
                                        const std::vector<TrackSegment>& segments,
                                        Entry entry) {
  std::vector<std::vector<double>> rows;
  for (const auto& a : segments) {
    auto& row = rows.emplace_back();
    for (const auto& b : segments) row.push_back((c.*entry)(a, b));
  }
  return rows;
}

TEST(RestCompliance, SmallestEigenvalue) {
  std::vector<TrackSegment> segments;
  for (int i = 0; i < 60; ++i) segments.push_back(segment(i, 0.49));
  const auto along = matrix(far_from_skin(10, 8, 60), segments, &RestCompliance::along);
  EXPECT_TRUE(is_above(0.0165, along));
  EXPECT_FALSE(is_above(0.017, along));
}

TEST(RestCompliance, IsSymmetricAndPositiveDefinite) {
  // Short and unequal segments of two materials.
  std::vector<TrackSegment> segments;
  double from = 0;
  for (int i = 0; i < 60; ++i) {
    const double length = 0.3 + 0.2 * (i % 3);
    const bool stiff = i % 40 > 20;
    segments.push_back({from, from + length, stiff ? 9.0 : 1.0, stiff ? 0.3 : 0.49});
    from += length;
  }
  for (const auto& [kernel, skin] :
       {std::pair(0.82, false), {0.85, true}, {1.5, true}, {10.0, false}, {10.0, true}}) {
    const RestCompliance c(radius, kernel_rings(kernel, radius, 8), from, skin);
    for (const Entry entry : {&RestCompliance::along, &RestCompliance::across}) {
      const auto m = matrix(c, segments, entry);
      EXPECT_TRUE(is_above(0, m)) << kernel << skin;
      double skew = 0;
      for (std::size_t i = 0; i < m.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) skew = std::max(skew, std::abs(m[i][j] - m[j][i]));
      }
      EXPECT_LT(skew, 1e-14);
    }
  }
}

TEST(RestCompliance, AKernelOfTheNeedlesOwnRadiusLeavesOutNothing) {
  const RestCompliance c(radius, kernel_rings(0.5, radius, 8), 60, true);
  EXPECT_EQ(c.along(segment(3), segment(3)), 0);
  EXPECT_EQ(c.across(segment(3), segment(4)), 0);
}

TEST(RestCompliance, TwoMaterials) {
  const auto c = far_from_skin(10, 8, 60);
  EXPECT_NEAR(c.along(segment(3, 0.45, 1), segment(5, 0.45, 9)),
              c.along(segment(3), segment(5)) / 3, 1e-16);
}

// Mindlin's solution in the half space z > 0, point by point: displacement at (x, y, z) along the force, a
// unit force at depth c along z or along x. Physics 7 (1936) 195.
struct Mindlin {
  double along;
  double across;
};
Mindlin mindlin(double x, double y, double z, double c, double nu) {
  const double r1 = std::sqrt(x * x + y * y + (z - c) * (z - c));
  const double r2 = std::sqrt(x * x + y * y + (z + c) * (z + c));
  const double factor = 1 / (16 * pi * (1 - nu));
  const double stiff = 3 - 4 * nu;
  const auto cube = [](double r) { return r * r * r; };
  const double along = stiff / r1 + (8 * (1 - nu) * (1 - nu) - stiff) / r2 +
                       (z - c) * (z - c) / cube(r1) +
                       (stiff * (z + c) * (z + c) - 2 * c * z) / cube(r2) +
                       6 * c * z * (z + c) * (z + c) / (cube(r2) * r2 * r2);
  const double across =
      stiff / r1 + 1 / r2 + x * x / cube(r1) + stiff * x * x / cube(r2) +
      2 * c * z / cube(r2) * (1 - 3 * x * x / (r2 * r2)) +
      4 * (1 - nu) * (1 - 2 * nu) / (r2 + z + c) * (1 - x * x / (r2 * (r2 + z + c)));
  return {factor * along, factor * across};
}

Mindlin mean_over_rings(double z, double c, double nu, const std::vector<Ring>& rings) {
  constexpr int n = 60;
  Mindlin mean{};
  for (const Ring& a : rings) {
    for (const Ring& b : rings) {
      for (int i = 0; i < n; ++i) {
        const double angle = 2 * pi * i / n;
        const double x = a.radius - b.radius * std::cos(angle);
        const double y = b.radius * std::sin(angle);
        // Turned by a right angle: the mean over both directions of the force.
        const Mindlin here = mindlin(x, y, z, c, nu);
        const Mindlin turned = mindlin(y, -x, z, c, nu);
        const double weight = a.weight * b.weight / n;
        mean.along += weight * here.along;
        mean.across += weight * (here.across + turned.across) / 2;
      }
    }
  }
  return mean;
}

TEST(RestCompliance, BelowASkinIsTheMeanOfMindlinsSolution) {
  constexpr double nu = 0.3;
  const std::vector<Ring> own{{radius, 1}};
  const auto kernel = kernel_rings(3, radius, 2);
  const RestCompliance c(radius, kernel, 60, true);
  constexpr std::array<std::pair<double, double>, 3> gauss{
      {{0.1127016653792583, 5 / 18.0}, {0.5, 8 / 18.0}, {0.8872983346207417, 5 / 18.0}}};
  for (const auto& [a, b] : {std::pair(1.0, 4.0), {6.0, 2.0}, {30.0, 50.0}}) {
    Mindlin mean{};
    for (const auto& [z, of_z] : gauss) {
      for (const auto& [z2, of_z2] : gauss) {
        const Mindlin ring = mean_over_rings(a + z, b + z2, nu, own);
        const Mindlin disc = mean_over_rings(a + z, b + z2, nu, kernel);
        mean.along += of_z * of_z2 * (ring.along - disc.along);
        mean.across += of_z * of_z2 * (ring.across - disc.across);
      }
    }
    EXPECT_NEAR(c.along(segment(a, nu), segment(b, nu)) / mean.along, 1, 1e-4) << a;
    EXPECT_NEAR(c.across(segment(a, nu), segment(b, nu)) / mean.across, 1, 1e-4) << a;
  }
}

}  // namespace
}  // namespace stylet
