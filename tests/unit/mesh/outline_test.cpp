#include "stylet/mesh/outline.hpp"

#include "stylet/base/errors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace stylet {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

const Ellipse ellipse{{0.5, -0.2}, 3.0, 0.6};
const std::vector<ReferencePoint> arrow = {{0, 0}, {2, 0}, {1, 0.5}, {2, 2}};

TEST(Outline, NearestPointOfAnEllipseIsPerpendicular) {
  for (double x = -3; x < 4; x += 0.37) {
    for (double y = -2; y < 2; y += 0.29) {
      const ReferencePoint p{x, y};
      const ReferencePoint q = nearest_point(ellipse, p);
      const double u = 2 * (q.x - 0.5) / 3.0;
      const double v = 2 * (q.y + 0.2) / 0.6;
      EXPECT_NEAR(u * u + v * v, 1, 1e-14);  // on the ellipse to rounding
      const Vector2 normal{u / 3.0, v / 0.6};
      const Vector2 away = p - q;
      if (norm(away) > 1e-9) {
        EXPECT_NEAR(cross(normal, away) / norm(normal) / norm(away), 0, 1e-6) << x << " " << y;
      }
    }
  }
}

TEST(Outline, InsideAndArea) {
  EXPECT_TRUE(is_inside(ellipse, {1.9, -0.2}));
  EXPECT_FALSE(is_inside(ellipse, {1.9, 0.0}));
  EXPECT_TRUE(is_inside(arrow, {0.9, 0.4}));
  EXPECT_FALSE(is_inside(arrow, {1.5, 0.5}));
  EXPECT_DOUBLE_EQ(enclosed_area(ellipse), std::acos(-1.0) * 1.5 * 0.3);
  EXPECT_DOUBLE_EQ(enclosed_area(arrow), 1.0);  // 0.5 below (1, 0.5), 0.5 above it
  EXPECT_EQ(nearest_point(arrow, {1, -1}), (ReferencePoint{1, 0}));
  EXPECT_EQ(bounding_box(arrow)[1], (ReferencePoint{2, 2}));
}

TEST(Outline, Errors) {
  const auto says = [](const Outline& outline, const std::string& part) {
    EXPECT_THAT([&] { check_outline(outline, "x"); }, ThrowsMessage<InputError>(HasSubstr(part)));
  };
  EXPECT_NO_THROW(check_outline(ellipse, "x"));
  EXPECT_NO_THROW(check_outline(arrow, "x"));
  says(Ellipse{{0, 0}, 1, 0}, "x: ellipse of 1 x 0 m; allowed");
  says(std::vector<ReferencePoint>{{0, 0}, {1, 0}}, "x has 2 points; allowed: 3 or more");
  says(std::vector<ReferencePoint>{{0, 0}, {1, 0}, {1, 1}, {0, 0}}, "points 4 and 1 are equal");
  says(std::vector<ReferencePoint>{{0, 0}, {1, 1}, {1, 0}, {0, 1}},
       "x crosses itself: edges 1 and 3");
  says(std::vector<ReferencePoint>{{0, 0}, {1, NAN}, {1, 0}}, "x: point 2 is not finite");
}

}  // namespace
}  // namespace stylet
