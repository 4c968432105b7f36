#include "stylet/needle/track.hpp"

#include "bench.hpp"
#include <gtest/gtest.h>

#include <numeric>

namespace stylet {

namespace {

// Sums of ten lengths of some centimetres.
constexpr double round_off = 1e-16;

/// Five nodes along y = 3 cm, 1 cm apart, from the skin at x = 8 cm.
struct Fixture {
  Mesh mesh{tissue(8, 6)};
  Track track;
  Fixture() {
    for (const double x : {0.08, 0.07, 0.06, 0.05, 0.04}) {
      track.push({node_at(mesh, {x, 0.03})});
    }
  }
  [[nodiscard]] std::vector<double> lengths(double from, double to) const {
    return track.lengths(mesh, from, to);
  }
};

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(Track, DistancesFromTheDeepestNode) {
  const Fixture f;
  const auto s = f.track.distances(f.mesh);
  ASSERT_EQ(s.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(s[i], 0.01 * (4 - static_cast<double>(i)), round_off);
  }
}

TEST(Track, WholePathGivesTributaryLengths) {
  const Fixture f;
  const auto lengths = f.lengths(0, 0.04);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(lengths[i], i == 0 || i == 4 ? 0.005 : 0.01, round_off);
  }
}

TEST(Track, SumIsTheCoveredLength) {
  Fixture f;
  for (const bool all_attached : {true, false}) {
    if (!all_attached) f.track.nodes()[4].attached = f.track.nodes()[3].attached = false;
    for (double from = 0; from < 0.04; from += 0.0037) {
      for (double to = from; to < 0.04; to += 0.0029) {
        EXPECT_NEAR(sum(f.lengths(from, to)), to - from, 10 * round_off);
      }
    }
  }
}

TEST(Track, LengthsBeyondThePathCountNothing) {
  const Fixture f;
  EXPECT_NEAR(sum(f.lengths(0.03, 1)), 0.01, round_off);
  EXPECT_EQ(sum(f.lengths(0.05, 1)), 0);
  EXPECT_EQ(sum(f.lengths(0.02, 0.02)), 0);
  EXPECT_EQ(sum(f.lengths(0.03, 0.01)), 0);
}

TEST(Track, PieceInsideAnEdgeIsSharedByItsHats) {
  const Fixture f;
  // From 2 to 4 mm behind the tip: hat of the node behind is x / 1 cm, so 0.6 mm of 2 mm.
  const auto lengths = f.lengths(0.002, 0.004);
  EXPECT_NEAR(lengths[3], 0.0006, round_off);
  EXPECT_NEAR(lengths[4], 0.0014, round_off);
  EXPECT_EQ(lengths[2], 0);
}

TEST(Track, DetachedNodeGivesItsShareTowardsTheSkin) {
  Fixture f;
  f.track.nodes()[4].attached = false;
  const auto lengths = f.lengths(0.004, 0.04);
  EXPECT_EQ(lengths[4], 0);
  EXPECT_NEAR(lengths[3], 0.006 + 0.005, round_off);
}

TEST(Track, HoldsNodesAndEdges) {
  const Fixture f;
  const auto nodes = f.track.nodes();
  EXPECT_TRUE(f.track.holds(nodes[2].node));
  EXPECT_FALSE(f.track.holds(node_at(f.mesh, {0.04, 0.04})));
  EXPECT_TRUE(f.track.has_edge(nodes[2].node, nodes[1].node));
  EXPECT_TRUE(f.track.has_edge(nodes[1].node, nodes[2].node));
  EXPECT_FALSE(f.track.has_edge(nodes[0].node, nodes[2].node));
}

TEST(Track, OneNodeHasNoLength) {
  const Fixture f;
  Track skin;
  skin.push({f.track.nodes()[0].node});
  EXPECT_EQ(skin.distances(f.mesh), std::vector<double>{0});
  EXPECT_EQ(skin.lengths(f.mesh, 0, 1), std::vector<double>{0});
}

}  // namespace

}  // namespace stylet
