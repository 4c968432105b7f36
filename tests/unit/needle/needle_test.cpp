#include "stylet/needle/needle.hpp"

#include "stylet/base/errors.hpp"

#include "bench.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

namespace stylet {

namespace {

constexpr double above = 10;  // N, more than any threshold here

/// Sum of the tip's weights: of its condition where it sticks, of its forces per newton where it cuts.
double sum_of_weights(const Needle& needle) {
  const auto set = needle.conditions();
  double sum = 0;
  if (needle.tip_contact() == TipContact::stick) {
    for (const auto& [point, share] : set.mean->shares) sum += share;
  } else {
    for (const auto& [place, force] : set.forces) sum += force;  // the threshold is 1 N
  }
  return sum;
}

TEST(Needle, StandsAtTheSkinFirst) {
  const Bench bench(Mesh(tissue(8, 6)), needle_at(0.033, 0.03));
  EXPECT_EQ(bench.needle.phase(), NeedlePhase::outside);
  EXPECT_EQ(bench.needle.track().size(), 1U);
  EXPECT_EQ(bench.mesh.point(bench.needle.track().tip()), (ReferencePoint{0.08, 0.033}));
  EXPECT_EQ(bench.needle.skin(), -0.08);
}

TEST(Needle, PointTipPushesUntilTheThreshold) {
  Bench bench(Mesh(tissue(8, 6)), needle_at(0.03, 0.03));
  for (int i = 0; i < 5; ++i) bench.step(0.05, 0.9);  // below the threshold of 1 N
  EXPECT_EQ(bench.needle.tip_contact(), TipContact::stick);
  EXPECT_EQ(bench.needle.track().size(), 1U);
  bench.step(0.05, above);
  EXPECT_EQ(bench.needle.tip_contact(), TipContact::cut);
  EXPECT_GT(bench.needle.track().size(), 1U);
}

/// Of the tip's forces while it cuts (N).
double cutting_force(const Needle& needle) {
  double sum = 0;
  for (const auto& [place, force] : needle.conditions().forces) sum += force;
  return sum;
}

TEST(Needle, CutsWithThatPartOfItsForceThatIsIn) {
  const double tip_length = 0.02;
  Bench bench(Mesh(tissue(16, 12, 0.2)), needle_at(0.0317, 0.04, tip_length));
  bench.step(0.05, 1e-6);
  EXPECT_GT(bench.needle.track().size(), 1U);  // any force breaks the skin
  while (!bench.motion.finished()) {
    bench.step(0.05, above);
    if (bench.needle.tip_contact() != TipContact::cut) continue;
    const double s = bench.needle.track().distances(bench.mesh).front();
    // Sums of a few shares.
    EXPECT_NEAR(cutting_force(bench.needle), std::min(1.0, s / tip_length), 1e-14);
  }
}

TEST(Needle, PressesOnTheSkinWithTheRestOfItsTip) {
  const double tip_length = 0.02;
  Bench bench(Mesh(tissue(16, 12)), needle_at(0.03, 0.04, tip_length));
  bench.step(0.05, above);
  while (!bench.motion.finished()) {
    bench.step(0.05, above);
    const double s = bench.needle.track().distances(bench.mesh).front();
    double on_skin = 0;  // but for the node of the entry, which is of the path too
    for (const auto& [place, force] : bench.needle.conditions().forces) {
      const int dof = bench.needle.track_operator().row(place)[0].dof;
      const ReferencePoint x = bench.mesh.point(dof / 2);
      if (x.x == 0.08 && x.y != 0.03) on_skin += force;
    }
    // The strip's hats without the middle one's share: elements are 5 mm.
    const double half = 0.5 * std::max(0.0, tip_length - s);
    const double middle = half < 0.005 ? half - 0.5 * half * half / 0.005 : 0.0025;
    const double force = std::min(1.0, s / tip_length);
    if (bench.needle.tip_contact() != TipContact::cut) continue;
    EXPECT_NEAR(on_skin, force * 2 * (half - middle) / tip_length, 1e-14);
  }
}

/// Bench of a needle after another that has gone along `height` as far as `depth`.
Bench second_needle(double height, double first_depth, NeedleTissue properties = {}) {
  Bench first(Mesh(tissue(16, 12, 0.2)), needle_at(0.0317, first_depth, 0.006), properties);
  while (!first.motion.finished()) first.step(0.05, above);
  properties.earlier = first.needle.leave();
  return {first.mesh, needle_at(height, 0.06, 0.006), properties};
}

TEST(Needle, ACutStaysCut) {
  for (const double beside : {0.0, 0.0005}) {  // below half of the diameter of 1.27 mm
    Bench bench = second_needle(0.0317 + beside, 0.03);
    bool held = false;
    while (!bench.motion.finished()) {
      bench.step(0.05, 0.9);  // below the threshold
      const double x = bench.needle.tip_point().x;
      if (bench.needle.tip_contact() != TipContact::cut) continue;
      // To the end of the first path without a force, and no further.
      EXPECT_GT(x, 0.05 - 1e-9);
      EXPECT_EQ(cutting_force(bench.needle), 0);
      held = held || x < 0.051;
    }
    EXPECT_TRUE(held);
    EXPECT_NEAR(bench.needle.tip_point().x, 0.05, 1e-6);
    EXPECT_EQ(bench.needle.tip_contact(), TipContact::stick);
  }
}

TEST(Needle, ANeedleBesideAnEarlierOneCutsAnew) {
  Bench bench = second_needle(0.0317 + 0.0007, 0.03);
  for (int i = 0; i < 10; ++i) bench.step(0.05, above);
  ASSERT_EQ(bench.needle.tip_contact(), TipContact::cut);
  EXPECT_GT(cutting_force(bench.needle), 0.5);
}

TEST(Needle, APunctureStaysOpen) {
  NeedleTissue properties;
  properties.membrane = {{0.02, 0.01}, {0.06, 0.01}, {0.06, 0.05}, {0.02, 0.05}};
  properties.puncture_force = 3;
  Bench same = second_needle(0.0317, 0.03, properties);
  while (!same.motion.finished()) same.step(0.05, 2);  // cuts, but does not puncture
  EXPECT_LT(same.needle.tip_point().x, 0.03);
  EXPECT_EQ(same.needle.counts().punctures, 0);
  Bench beside = second_needle(0.04, 0.03, properties);
  while (!beside.motion.finished()) beside.step(0.05, 2);
  EXPECT_TRUE(beside.needle.at_membrane());
}

TEST(Needle, MeetsAMembraneCloserToTheSkinThanItsFirstCut) {
  NeedleTissue properties;  // 1 mm under the skin, elements of 1 cm
  properties.membrane = {{0.01, 0.01}, {0.079, 0.01}, {0.079, 0.05}, {0.01, 0.05}};
  properties.puncture_force = 3;
  Bench bench(Mesh(tissue(8, 6)), needle_at(0.03, 0.03), properties);
  for (int i = 0; i < 5; ++i) bench.step(0.05, 2);  // cuts, but does not puncture
  EXPECT_TRUE(bench.needle.at_membrane());
  EXPECT_EQ(bench.needle.counts().punctures, 0);
  EXPECT_EQ(bench.needle.track().size(), 1U);
  bench.step(0.05, above);
  EXPECT_EQ(bench.needle.counts().punctures, 1);
  EXPECT_GT(bench.needle.track().size(), 1U);
}

TEST(Needle, CutsAsFarAsItMoves) {
  // In tissue that does not give, the tip in the reference mesh is the tip in the world.
  for (const double jitter : {0.0, 0.25}) {
    Bench bench(Mesh(tissue(16, 12, jitter)), needle_at(0.0317, 0.05));
    while (!bench.motion.finished()) {
      bench.step(0.05, above);
      const auto tip = bench.needle.tip_point().in_plane();
      // A step is accepted when the gap is below 1e-4 of its 1 mm; the first cut goes half an
      // element ahead.
      if (bench.needle.tip_contact() != TipContact::cut) continue;
      EXPECT_NEAR(Axis::along(tip), bench.needle.tip(), 1.1e-7);
      EXPECT_NEAR(tip.y, 0.0317, 1e-15);
    }
    EXPECT_GT(bench.needle.counts().hand_overs, 8);
  }
}

TEST(Needle, EveryEditLeavesValidTriangles) {
  for (int i = 0; i < 20; ++i) {
    const double height = 0.007 + 0.0023 * i;
    Bench bench(Mesh(tissue(16, 12, 0.25)), needle_at(height, 0.06, i % 2 == 0 ? 0.006 : 0));
    std::vector<int> all(static_cast<std::size_t>(bench.mesh.n_cells()));
    std::iota(all.begin(), all.end(), 0);
    while (!bench.motion.finished()) {
      // The floor of a hand-over (needle.cpp).
      bench.step(0.1, above, [&] { ASSERT_GE(bench.mesh.worst_quality(all), 0.03); });
    }
  }
}

TEST(Needle, PathIsAChainOfEdges) {
  Bench bench(Mesh(tissue(16, 12, 0.25)), needle_at(0.0273, 0.06));
  while (!bench.motion.finished()) bench.step(0.2, above);  // several hand-overs a step
  const auto nodes = bench.needle.track().nodes();
  std::set<int> distinct;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    EXPECT_TRUE(distinct.insert(nodes[i].node).second);
    EXPECT_NEAR(bench.mesh.point(nodes[i].node).y, 0.0273, 1e-15);
    if (i == 0) continue;
    EXPECT_EQ(bench.mesh.cells_with(nodes[i - 1].node, nodes[i].node).size(), 2U);
    EXPECT_LT(bench.mesh.point(nodes[i].node).x, bench.mesh.point(nodes[i - 1].node).x);
  }
}

TEST(Needle, TipWeightsSumToOne) {
  for (const double tip_length : {0.0, 0.001, 0.006, 0.02}) {
    Bench bench(Mesh(tissue(16, 12, 0.2)), needle_at(0.0317, 0.04, tip_length));
    EXPECT_NEAR(sum_of_weights(bench.needle), 1, 1e-15);  // at the skin
    while (!bench.motion.finished()) {
      bench.step(0.05, above);
      const double s = bench.needle.track().distances(bench.mesh).front();
      const bool all = tip_length == 0 || bench.needle.tip_contact() == TipContact::stick;
      if (bench.needle.tip_contact() == TipContact::open) continue;
      // A few divisions of lengths by the tip's.
      const double force = all ? 1 : std::min(1.0, s / tip_length);
      EXPECT_NEAR(sum_of_weights(bench.needle), force, 1e-14);
    }
  }
}

TEST(Needle, PointTipLoadsOneNode) {
  Bench bench(Mesh(tissue(16, 12)), needle_at(0.03, 0.02));
  for (int i = 0; i < 5; ++i) bench.step(0.05, above);
  const auto set = bench.needle.conditions();
  ASSERT_EQ(set.forces.size(), 1U);
  const SparseRow row = bench.needle.track_operator().row(set.forces[0].place);
  ASSERT_EQ(row.size(), 1U);
  EXPECT_EQ(row[0].dof, Axis::along_dof(bench.needle.track().tip()));
  EXPECT_EQ(row[0].value * set.forces[0].force, -1);  // 1 N towards -x
}

TEST(Needle, ShaftIsHeldOnItsAxis) {
  Bench bench(Mesh(tissue(16, 12, 0.2)), needle_at(0.0317, 0.03));
  while (!bench.motion.finished()) bench.step(0.05, above);
  std::set<int> held;
  for (const auto& hold : bench.needle.conditions().held) {
    EXPECT_FALSE(hold.velocity);
    EXPECT_NEAR(hold.value, 0, 1e-15);  // the nodes stand on the axis already
    const SparseRow row = bench.needle.track_operator().row(hold.place);
    ASSERT_EQ(row.size(), 1U);
    EXPECT_EQ(row[0].value, 1);
    held.insert(row[0].dof);
  }
  for (const auto& shaft : bench.needle.track().nodes()) {
    EXPECT_TRUE(held.contains(Axis::across_dof(shaft.node)));
  }
}

TEST(Needle, StopsAtTheMembraneUntilItIsPunctured) {
  NeedleTissue tissue_properties;
  tissue_properties.membrane = {{0.02, 0.01}, {0.06, 0.01}, {0.06, 0.05}, {0.02, 0.05}};
  tissue_properties.puncture_force = 3;
  Bench bench(Mesh(tissue(16, 12, 0.2)), needle_at(0.0317, 0.07), tissue_properties);
  while (!bench.needle.at_membrane()) bench.step(0.05, 2);  // cuts, but does not puncture
  // The crossing of straight lines.
  EXPECT_NEAR(bench.needle.tip_point().x, 0.06, 1e-15);
  for (int i = 0; i < 4; ++i) bench.step(0.05, 2);
  EXPECT_TRUE(bench.needle.at_membrane());
  EXPECT_EQ(bench.needle.counts().punctures, 0);
  EXPECT_NEAR(bench.needle.tip_point().x, 0.06, 1e-15);
  while (!bench.motion.finished()) bench.step(0.05, 3.1);
  EXPECT_EQ(bench.needle.counts().punctures, 2);  // in and out again
  EXPECT_LT(bench.needle.tip_point().x, 0.02);
}

TEST(Needle, AdvanceWithoutASolutionIsAnError) {
  // Tissue whose gap jumps from far too large to far too small where the tip has gone 0.3 mm.
  Bench bench(Mesh(tissue(16, 12, 0.2)), needle_at(0.0317, 0.06));
  while (bench.needle.counts().hand_overs < 2) bench.step(0.05, 2);
  Needle& needle = bench.needle;
  needle.start_step(bench.motion.next(0.05));
  const double from = Axis::along(bench.mesh.point(needle.track().tip()));
  const auto solve = [&] {
    while (needle.wants_edit()) rewrite(bench.mesh, needle.plan(still(bench.mesh)));
    const double tip = Axis::along(bench.mesh.point(needle.track().tip()));
    const double gap = tip < from + 3e-4 ? 1e-3 : -1e-3;
    const double to = needle.tip() + 1e-3;
    const std::vector<int> points = needle.loaded_points();
    std::vector<PointTrial> trials(points.size());
    for (auto& point : trials) point.u = {to - tip - gap, 0};
    return needle.review(TrackTrial(points, trials), above);
  };
  try {
    // Where the gap jumps the tip holds; but there it bears more than its threshold.
    for (int i = 0; i < 200; ++i) ASSERT_FALSE(solve());
    FAIL();
  } catch (const NumericalError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("the advance of needle 'needle' has no solution"));
    EXPECT_THAT(error.what(), testing::HasSubstr("gap that jumps from 0.001"));
  }
}

TEST(Needle, SameDecisionsInEveryNumbering) {
  for (const double jitter : {0.0, 0.2}) {
    const MeshData data = tissue(12, 9, jitter);
    const double height = 0.03;  // without jitter on no line of nodes, but halfway: all ties
    Bench plain(Mesh(data), needle_at(height, 0.06));
    Bench other(permuted(data, 4), needle_at(height, 0.06));
    while (!plain.motion.finished()) {
      plain.step(0.05, above);
      other.step(0.05, above);
      ASSERT_EQ(plain.needle.counts().hand_overs, other.needle.counts().hand_overs);
      const auto a = plain.needle.track().nodes();
      const auto b = other.needle.track().nodes();
      for (std::size_t i = 0; i < a.size(); ++i) {
        // Round-off of cells in another cyclic order.
        EXPECT_LT(distance(plain.mesh.point(a[i].node), other.mesh.point(b[i].node)), 1e-14);
      }
    }
  }
}

}  // namespace

}  // namespace stylet
