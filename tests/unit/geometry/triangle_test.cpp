#include "stylet/geometry/triangle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace stylet {

namespace {

using P = ReferencePoint;
// A few operations on numbers near one.
constexpr double round_off = 1e-15;

TEST(Triangle, Area) {
  EXPECT_EQ(signed_area(P{0, 0}, P{2, 0}, P{0, 3}), 3);
  EXPECT_EQ(signed_area(P{0, 0}, P{0, 3}, P{2, 0}), -3);
  EXPECT_EQ(signed_area(P{0, 0}, P{1, 1}, P{3, 3}), 0);
}

TEST(Triangle, Quality) {
  EXPECT_NEAR(quality(P{0, 0}, P{1, 0}, P{0.5, std::sqrt(0.75)}), 1, round_off);
  EXPECT_NEAR(quality(P{0, 0}, P{1, 0}, P{0, 1}), std::sqrt(3.0) / 2, round_off);
  EXPECT_NEAR(quality(P{0, 0}, P{0, 1}, P{1, 0}), -std::sqrt(3.0) / 2, round_off);
  EXPECT_EQ(quality(P{0, 0}, P{1, 0}, P{2, 0}), 0);
  EXPECT_EQ(quality(P{1, 1}, P{1, 1}, P{1, 1}), 0);  // a point has none
}

TEST(Triangle, QualityDoesNotDependOnSizeAndPlace) {
  const double q = quality(P{0, 0}, P{1, 0.2}, P{0.3, 0.7});
  const double small = quality(P{5e-3, 2e-3}, P{6e-3, 2.2e-3}, P{5.3e-3, 2.7e-3});
  // Differences of the shifted coordinates lose two digits.
  EXPECT_NEAR(small, q, 1e-13);
}

TEST(Triangle, Barycentric) {
  const P a{0.1, 0.2};
  const P b{1.3, 0.1};
  const P c{0.4, 0.9};
  const auto at_b = barycentric(a, b, c, b);
  EXPECT_NEAR(at_b[0], 0, round_off);
  EXPECT_NEAR(at_b[1], 1, round_off);
  const P p{0.6, 0.5};
  const auto w = barycentric(a, b, c, p);
  EXPECT_EQ(w[0] + w[1] + w[2], 1);
  EXPECT_NEAR(w[0] * a.x + w[1] * b.x + w[2] * c.x, p.x, round_off);
  EXPECT_NEAR(w[0] * a.y + w[1] * b.y + w[2] * c.y, p.y, round_off);
  EXPECT_LT(barycentric(a, b, c, P{-1, 0})[1], 0);
}

TEST(Triangle, RayMeetsSegment) {
  const auto hit = ray_segment(P{2, 1}, Vector2{-1, 0}, P{0, 0}, P{0, 4});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->s, 2);
  EXPECT_EQ(hit->fraction, 0.25);
  const auto behind = ray_segment(P{2, 1}, Vector2{1, 0}, P{0, 0}, P{0, 4});
  ASSERT_TRUE(behind);
  EXPECT_LT(behind->s, 0);
  EXPECT_FALSE(ray_segment(P{2, 1}, Vector2{0, 1}, P{0, 0}, P{0, 4}));  // parallel
}

TEST(Triangle, InsidePolygon) {
  const std::vector<P> corner = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  const std::span<const P> polygon = corner;
  EXPECT_TRUE(inside_polygon(polygon, P{0.5, 1.5}));
  EXPECT_TRUE(inside_polygon(polygon, P{1.5, 0.5}));
  EXPECT_FALSE(inside_polygon(polygon, P{1.5, 1.5}));  // in the bounding box only
  EXPECT_FALSE(inside_polygon(polygon, P{-0.5, 0.5}));
}

TEST(Points, Arithmetic) {
  EXPECT_EQ(midpoint(P{0, 2}, P{4, 0}), (P{2, 1}));
  EXPECT_EQ(distance(P{0, 0}, P{3, 4}), 5);
  EXPECT_EQ(displaced(P{1, 2}, Vector2{0.5, -1}), (WorldPoint{1.5, 1}));
  EXPECT_EQ(cross(Vector2{1, 0}, Vector2{0, 1}), 1);
}

}  // namespace

}  // namespace stylet
