#include "stylet/needle/surface_crossings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace stylet {
namespace {

/// A closed surface around the origin: a globe of that many meridians and parallels.
std::vector<SurfaceTriangle> globe(double radius, int meridians, int parallels) {
  const auto at = [&](int i, int k) -> ReferencePlace {
    if (k == 0) return {0, 0, radius};
    if (k == parallels) return {0, 0, -radius};
    const double a = 2 * std::numbers::pi * (i % meridians) / meridians;
    const double b = std::numbers::pi * k / parallels;
    return {radius * std::sin(b) * std::cos(a), radius * std::sin(b) * std::sin(a),
            radius * std::cos(b)};
  };
  std::vector<SurfaceTriangle> surface;
  for (int k = 0; k < parallels; ++k) {
    for (int i = 0; i < meridians; ++i) {
      if (k > 0) surface.push_back({at(i, k), at(i, k + 1), at(i + 1, k)});
      if (k + 1 < parallels) surface.push_back({at(i + 1, k), at(i, k + 1), at(i + 1, k + 1)});
    }
  }
  return surface;
}

/// Crossings that are apart: a line through an edge or a corner meets several triangles at one place.
std::vector<double> places(const std::vector<double>& crossings) {
  std::vector<double> apart;
  for (const double x : crossings) {
    if (apart.empty() || x - apart.back() > 1e-9) apart.push_back(x);
  }
  return apart;
}

TEST(SurfaceCrossings, ALineGoesInAndOutOfAClosedSurface) {
  const auto surface = globe(1, 24, 24);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const ReferencePlace through{0.5 * number(random), 0.5 * number(random), 0.5 * number(random)};
    Vector3 r{number(random), number(random), number(random)};
    r = 1 / norm(r) * r;
    const auto found = places(surface_crossings(surface, through + -3.0 * r, r, 6));
    ASSERT_EQ(found.size(), 2U);
    for (const double s : found) {
      const double away = distance(through + (s - 3) * r, ReferencePlace{});
      EXPECT_NEAR(away, 1, 0.02);  // triangles cut the sphere short
    }
    EXPECT_EQ(places(surface_crossings(surface, through, r, 6)).size(), 1U);
    EXPECT_TRUE(surface_crossings(surface, through, r, 0.2).empty());
  }
}

TEST(SurfaceCrossings, NoneIsMissedThroughCornersAndEdges) {
  const auto surface = globe(1, 8, 8);
  for (const SurfaceTriangle& triangle : surface) {
    const ReferencePlace a = triangle[0];
    const ReferencePlace b = triangle[1];
    for (const double share : {0.0, 0.5, 0.3}) {
      const Vector3 to = (a - ReferencePlace{}) + share * (b - a);
      const Vector3 r = 1 / norm(to) * to;
      const auto found = places(surface_crossings(surface, ReferencePlace{} + -2.0 * r, r, 4));
      ASSERT_EQ(found.size(), 2U) << to.x << " " << to.y << " " << to.z;
      EXPECT_NEAR(found[1], 2 + norm(to), 1e-12);
    }
  }
}

TEST(SurfaceCrossings, TheNearestPointOfATriangle) {
  const SurfaceTriangle triangle{ReferencePlace{0, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-3, 3);
  for (int i = 0; i < 200; ++i) {
    const ReferencePlace p{number(random), number(random), number(random)};
    const double found = distance(nearest_point(triangle, p), p);
    double least = 1e300;
    constexpr int n = 60;
    for (int k = 0; k <= n; ++k) {
      for (int m = 0; m + k <= n; ++m) {
        const ReferencePlace x{2.0 * k / n, 1.0 * m / n, 0};
        least = std::min(least, distance(x, p));
      }
    }
    EXPECT_LE(found, least + 1e-12);
    EXPECT_GT(found, least - 0.03);
  }
}

}  // namespace
}  // namespace stylet
