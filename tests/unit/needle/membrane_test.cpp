#include "stylet/needle/membrane.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace stylet {

namespace {

const Vector2 left{-1, 0};
/// Edge 0 bottom, 1 right, 2 top, 3 left.
const std::vector<ReferencePoint> square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
/// Corner 0 at the right, then top, left, bottom.
const std::vector<ReferencePoint> diamond = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

TEST(Membrane, NearestEdgeFirst) {
  const auto crossing = first_crossing(square, {3, 0.3}, left, 5, {});
  ASSERT_TRUE(crossing);
  EXPECT_EQ(crossing->edge, 1);
  EXPECT_EQ(crossing->distance, 2);
}

TEST(Membrane, PuncturedEdgesAreOpen) {
  const auto far = first_crossing(square, {3, 0.3}, left, 5, {1});
  ASSERT_TRUE(far);
  EXPECT_EQ(far->edge, 3);
  EXPECT_EQ(far->distance, 3);
  EXPECT_FALSE(first_crossing(square, {3, 0.3}, left, 5, {1, 3}));
}

TEST(Membrane, OnlyWithinTheLength) {
  EXPECT_FALSE(first_crossing(square, {3, 0.3}, left, 1.999, {}));
  EXPECT_TRUE(first_crossing(square, {3, 0.3}, left, 2, {}));
}

TEST(Membrane, BehindIsNotAhead) {
  EXPECT_FALSE(first_crossing(square, {-1, 0.3}, left, 5, {}));
  EXPECT_FALSE(first_crossing(square, {3, 2}, left, 5, {}));  // beside
}

TEST(Membrane, AlongAnEdgeMeetsTheEdgesAtItsEnds) {
  // The needle runs along the top: parallel to edge 2, but edge 1 ends on its way.
  const auto crossing = first_crossing(square, {3, 1}, left, 5, {});
  ASSERT_TRUE(crossing);
  EXPECT_EQ(crossing->edge, 1);
  EXPECT_EQ(crossing->distance, 2);
}

TEST(Membrane, VertexDoesNotSlipThrough) {
  const auto hit = first_crossing(diamond, {3, 0}, left, 5, {});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->distance, 2);
  EXPECT_TRUE(hit->edge == 0 || hit->edge == 3);
  // The vertex belongs to both edges: the other one closes it still.
  const auto other = first_crossing(diamond, {3, 0}, left, 5, {hit->edge});
  ASSERT_TRUE(other);
  EXPECT_EQ(other->distance, 2);
  EXPECT_EQ(other->edge, 3 - hit->edge);
}

TEST(Membrane, TouchedVertexCounts) {
  EXPECT_TRUE(first_crossing(diamond, {3, 1}, left, 5, {}));
  EXPECT_FALSE(first_crossing(diamond, {3, 1 + 1e-9}, left, 5, {}));
}

TEST(Membrane, StandingOnAnEdge) {
  const auto hit = first_crossing(square, {1, 0.3}, left, 5, {});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->edge, 1);
  EXPECT_EQ(hit->distance, 0);
}

TEST(Membrane, NoMembrane) {
  EXPECT_FALSE(first_crossing({}, {3, 0}, left, 5, {}));
}

}  // namespace

}  // namespace stylet
