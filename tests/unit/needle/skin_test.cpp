#include "stylet/needle/skin.hpp"

#include "stylet/needle/earlier_cuts.hpp"

#include "bench.hpp"
#include <gtest/gtest.h>

#include <cmath>

namespace stylet {

namespace {

double total(const std::vector<NodeShare>& shares) {
  double sum = 0;
  for (const auto& share : shares) sum += share.value;
  return sum;
}

TEST(Skin, SharesAreTheLengthsThatNodesStandFor) {
  const Mesh mesh(tissue(16, 12));  // elements of 5 mm
  const int entry = node_at(mesh, {0.08, 0.03});
  const Skin skin(mesh, entry, 0.012);
  EXPECT_EQ(skin.nodes().size(), 7U);  // 15 mm to either side
  for (const double width : {1e-5, 0.004, 0.01, 0.017, 0.024}) {
    const auto shares = skin.lengths(mesh, width);
    EXPECT_NEAR(total(shares), width, 1e-17);
    double moment = 0;  // hats reproduce a linear function
    double second = 0;
    for (const auto& [node, value] : shares) {
      const double y = mesh.point(node).y - 0.03;
      moment += value * y;
      second += value * y * y;
    }
    EXPECT_NEAR(moment, 0, 1e-17);
    // Linear interpolation of y^2 is above it by at most a quarter of the element's square.
    EXPECT_GE(second, std::pow(width, 3) / 12);
    EXPECT_LE(second, std::pow(width, 3) / 12 + width * 0.005 * 0.005 / 4);
  }
}

TEST(Skin, EndsAtACorner) {
  const Mesh mesh(tissue(16, 12));
  const int entry = node_at(mesh, {0.08, 0.05});
  const Skin skin(mesh, entry, 0.03);
  for (const int node : skin.nodes()) EXPECT_EQ(mesh.point(node).x, 0.08);
  EXPECT_NEAR(total(skin.lengths(mesh, 0.06)), 0.03 + 0.01, 1e-16);
}

TEST(EarlierCuts, FreeToTheEndOfAPath) {
  EarlierCuts cuts;
  cuts.paths = {{{8, 3}, {7, 3}, {6, 3.05}, {5, 3.05}}};
  const Vector3 left{-1, 0};
  EXPECT_NEAR(cuts.free_length({8, 3}, left, 0.1), 3, 1e-12);
  EXPECT_NEAR(cuts.free_length({6.5, 3}, left, 0.1), 1.5, 1e-12);
  EXPECT_EQ(cuts.free_length({5, 3.05}, left, 0.1), 0);                  // stands at its end
  EXPECT_EQ(cuts.free_length({9, 3}, left, 0.1), 0);                     // outside of the tissue
  EXPECT_EQ(cuts.free_length({8, 3.2}, left, 0.1), 0);                   // beside
  EXPECT_NEAR(cuts.free_length({7.5, 3.05}, {0, 1}, 0.1), 0.05, 1e-12);  // across: out of it
  EXPECT_EQ(EarlierCuts{}.free_length({8, 3}, left, 0.1), 0);
}

TEST(EarlierCuts, PathsThatFollowEachOther) {
  EarlierCuts cuts;
  cuts.paths = {{{8, 3}, {6, 3}}, {{7, 3}, {4, 3}}};
  EXPECT_NEAR(cuts.free_length({8, 3}, {-1, 0}, 0.1), 4, 1e-12);
}

}  // namespace

}  // namespace stylet
