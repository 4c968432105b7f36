#include "stylet/needle/membrane.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace stylet {

namespace {

const Vector2 left{-1, 0};
/// Edge 0 bottom, 1 right, 2 top, 3 left.
const std::vector<ReferencePoint> square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
/// Corner 0 at the right, then top, left, bottom.
const std::vector<ReferencePoint> diamond = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

constexpr double radius = 0.1;

std::optional<double> cross(const std::vector<ReferencePoint>& polygon,
                            ReferencePoint p,
                            double length,
                            const std::vector<ReferencePlace>& punctures = {}) {
  return first_crossing(polygon, p, left, length, punctures, radius);
}

TEST(Membrane, NearestEdgeFirst) {
  EXPECT_EQ(cross(square, {3, 0.3}, 5), 2);
}

TEST(Membrane, OpenWherePunctured) {
  EXPECT_EQ(cross(square, {3, 0.3}, 5, {{1, 0.3}}), 3);  // the far side
  EXPECT_FALSE(cross(square, {3, 0.3}, 5, {{1, 0.3}, {0, 0.3}}));
  // Another needle through the same edge.
  EXPECT_EQ(cross(square, {3, 0.3 + 0.9 * radius}, 5, {{1, 0.3}}), 3);
  EXPECT_EQ(cross(square, {3, 0.3 + 1.1 * radius}, 5, {{1, 0.3}}), 2);
}

TEST(Membrane, OnlyWithinTheLength) {
  EXPECT_FALSE(cross(square, {3, 0.3}, 1.999));
  EXPECT_TRUE(cross(square, {3, 0.3}, 2));
}

TEST(Membrane, BehindIsNotAhead) {
  EXPECT_FALSE(cross(square, {-1, 0.3}, 5));
  EXPECT_FALSE(cross(square, {3, 2}, 5));  // beside
}

TEST(Membrane, AlongAnEdgeMeetsTheEdgesAtItsEnds) {
  EXPECT_EQ(cross(square, {3, 1}, 5), 2);
}

TEST(Membrane, AVertexIsOneCrossing) {
  EXPECT_EQ(cross(diamond, {3, 0}, 5), 2);
  // Both edges that meet there are open then.
  EXPECT_EQ(cross(diamond, {3, 0}, 5, {{1, 0}}), 4);
  EXPECT_FALSE(cross(diamond, {3, 0}, 5, {{1, 0}, {-1, 0}}));
}

TEST(Membrane, TouchedVertexCounts) {
  EXPECT_TRUE(cross(diamond, {3, 1}, 5));
  EXPECT_FALSE(cross(diamond, {3, 1 + 1e-9}, 5));
}

TEST(Membrane, StandingOnAnEdge) {
  EXPECT_EQ(cross(square, {1, 0.3}, 5), 0);
  EXPECT_EQ(cross(square, {1 - 1e-12, 0.3}, 5), 0);  // to round-off
}

TEST(Membrane, NoMembrane) {
  EXPECT_FALSE(cross({}, {3, 0}, 5));
}

}  // namespace

}  // namespace stylet
