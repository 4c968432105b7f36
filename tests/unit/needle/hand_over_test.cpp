// Hand-overs, flips and the copies that they are tried on.
#include "stylet/needle/advance.hpp"
#include "stylet/needle/local_mesh.hpp"

#include "bench.hpp"
#include <gtest/gtest.h>

#include <numeric>

namespace stylet {

namespace {

struct Tip {
  Track track;
  AdvanceBase base;
};

/// A tip at a node, with its neighbour furthest to the right behind.
std::optional<Tip> tip_at(const Mesh& mesh, ReferencePoint at) {
  const int node = node_at(mesh, at);
  int behind = node;
  for (const int other : mesh.neighbours(node)) {
    const auto angle = [&](int n) {
      const Vector2 v = mesh.point(n) - mesh.point(node);
      return n == node ? -1 : v.x / norm(v);
    };
    if (angle(other) > angle(behind)) behind = other;
  }
  Tip tip;
  tip.track.push({behind});
  tip.track.push({node});
  const auto way = find_way(mesh, tip.track, {at.y}, still(mesh));
  if (!way) return std::nullopt;
  tip.base = *way;
  return tip;
}

TEST(QualityAfter, IsThatOfTheMovedMesh) {
  Mesh mesh(tissue(8, 6, 0.2));
  const int a = node_at(mesh, {0.04, 0.03});
  const int b = node_at(mesh, {0.05, 0.03});
  const std::vector<NodeEdit> moves{{a, mesh.point(a) + Vector2{2e-3, 1e-3}, {}},
                                    {b, mesh.point(b) + Vector2{-1e-3, 2e-3}, {}}};
  const double expected = quality_after(mesh, moves);
  for (const auto& move : moves) mesh.move_node(move.node, move.x);
  std::vector<int> cells(mesh.cells_around(a).begin(), mesh.cells_around(a).end());
  cells.insert(cells.end(), mesh.cells_around(b).begin(), mesh.cells_around(b).end());
  EXPECT_EQ(mesh.worst_quality(cells), expected);
}

TEST(HandOver, PlacesAndPromisedQuality) {
  const MeshData data = tissue(16, 12, 0.25);
  int planned = 0;
  for (int node = 0; node < data.n_nodes(); ++node) {
    Mesh mesh(data);
    if (mesh.is_locked(node)) continue;
    const auto tip = tip_at(mesh, mesh.point(node));
    if (!tip) continue;
    const ReferencePoint p = mesh.point(node);
    const ReferencePoint behind = mesh.point(tip->track.behind_tip());
    const auto plan = plan_hand_over(mesh, tip->track, tip->base, still(mesh));
    if (!plan || plan->quality < 0.03) continue;
    ++planned;
    EXPECT_FALSE(mesh.is_locked(plan->new_tip));
    EXPECT_FALSE(tip->track.holds(plan->new_tip));
    rewrite(mesh, plan->edits);
    EXPECT_EQ(mesh.point(plan->new_tip), p);
    EXPECT_EQ(mesh.point(node), midpoint(behind, p));
    std::vector<int> all(static_cast<std::size_t>(mesh.n_cells()));
    std::iota(all.begin(), all.end(), 0);
    EXPECT_GE(mesh.worst_quality(all), std::min(plan->quality, Mesh(data).worst_quality(all)));
    // The path is still made of edges.
    EXPECT_EQ(mesh.cells_with(plan->new_tip, node).size(), 2U);
    EXPECT_FALSE(mesh.cells_with(node, tip->track.behind_tip()).empty());
  }
  EXPECT_GT(planned, 100);
}

TEST(HandOver, AtTheSkinTheNewTipGoesAhead) {
  const Mesh mesh(tissue(8, 6));
  Track track;
  track.push({node_at(mesh, {0.08, 0.03})});
  const auto way = find_way(mesh, track, {0.03}, still(mesh));
  ASSERT_TRUE(way);
  EXPECT_EQ(way->hand_over, 0);
  const auto plan = plan_hand_over(mesh, track, *way, still(mesh));
  ASSERT_TRUE(plan);
  ASSERT_EQ(plan->edits.moves.size(), 1U);  // the skin is not dented
  EXPECT_NEAR(plan->edits.moves[0].x.x, 0.08 - 0.5 * way->distance, 1e-17);
  EXPECT_EQ(plan->edits.moves[0].x.y, 0.03);
}

TEST(HandOver, SameInEveryNumbering) {
  for (const double jitter : {0.0, 0.2}) {
    const MeshData data = tissue(8, 6, jitter);
    const Mesh plain(data);
    for (unsigned seed = 1; seed < 5; ++seed) {
      const Mesh other = permuted(data, seed);
      for (int node = 0; node < plain.n_nodes(); ++node) {
        if (plain.is_locked(node)) continue;
        const auto a = tip_at(plain, plain.point(node));
        const auto b = tip_at(other, plain.point(node));
        ASSERT_TRUE(a && b);
        const auto pa = plan_hand_over(plain, a->track, a->base, still(plain));
        const auto pb = plan_hand_over(other, b->track, b->base, still(other));
        ASSERT_EQ(pa.has_value(), pb.has_value());
        if (!pa) continue;
        EXPECT_EQ(plain.point(pa->new_tip), other.point(pb->new_tip));
        EXPECT_EQ(pa->edits.flips.size(), pb->edits.flips.size());
        // Cells in another cyclic order round differently.
        EXPECT_NEAR(pa->quality, pb->quality, 1e-14);
      }
    }
  }
}

/// All cells, and a track along a row of nodes.
struct Repairable {
  Mesh mesh{tissue(16, 12, 0.29)};
  Track track;
  std::vector<int> cells = std::vector<int>(static_cast<std::size_t>(mesh.n_cells()));
  Repairable() {
    std::iota(cells.begin(), cells.end(), 0);
    for (double x = 0.08; x > 0.04; x -= 0.005) track.push({node_at(mesh, {x, 0.03})});
    mesh.lock_curve("left");
  }
};

TEST(BestFlip, NeverLockedEdgesNorThePath) {
  Repairable r;
  int flips = 0;
  for (; flips < 200; ++flips) {
    const auto edge = best_flip(r.mesh, r.track, r.cells, 1.0);
    if (!edge) break;
    ASSERT_FALSE(r.mesh.is_locked_edge(edge->a, edge->b));
    ASSERT_FALSE(r.track.has_edge(edge->a, edge->b));
    const auto both = r.mesh.cells_with(edge->a, edge->b);
    const double before = r.mesh.worst_quality(both);
    r.mesh.flip_edge(edge->a, edge->b);
    // A flip must be worth it by 5 % (local_mesh.cpp).
    EXPECT_GE(r.mesh.worst_quality(both), 1.05 * before);
  }
  EXPECT_GT(flips, 10);
  EXPECT_LT(flips, 200);  // and it ends
}

TEST(BestFlip, GoodTrianglesAreLeftAlone) {
  const Repairable r;
  const double worst = r.mesh.worst_quality(r.cells);
  EXPECT_FALSE(best_flip(r.mesh, r.track, r.cells, worst));
  EXPECT_FALSE(best_flip(r.mesh, r.track, {}, 1.0));
}

TEST(BestFlip, TiesByPosition) {
  // Flattened squares in a symmetric mesh: many equally good flips.
  const MeshData data = tissue(8, 24);
  const Mesh plain(data);
  std::vector<int> cells(static_cast<std::size_t>(plain.n_cells()));
  std::iota(cells.begin(), cells.end(), 0);
  Mesh squeezed(plain);
  const auto squeeze = [](Mesh& mesh) {
    for (int node = 0; node < mesh.n_nodes(); ++node) {
      const auto x = mesh.point(node);
      const bool row = std::abs(x.y - 0.02) < 1e-9 || std::abs(x.y - 0.04) < 1e-9;
      if (row && !mesh.is_locked(node)) mesh.move_node(node, x + Vector2{0.004, 0});
    }
  };
  squeeze(squeezed);
  const auto first = best_flip(squeezed, {}, cells, 0.6);
  ASSERT_TRUE(first);
  for (unsigned seed = 1; seed < 6; ++seed) {
    Mesh other = permuted(data, seed);
    squeeze(other);
    const auto edge = best_flip(other, {}, cells, 0.6);
    ASSERT_TRUE(edge);
    EXPECT_EQ(midpoint(other.point(edge->a), other.point(edge->b)),
              midpoint(squeezed.point(first->a), squeezed.point(first->b)));
  }
}

TEST(Repair, ReachesWhatIsWantedOrStops) {
  Repairable r;
  const int tip = r.track.tip();
  r.mesh.move_node(tip, r.mesh.point(tip) + Vector2{-2.5e-3, 0});
  std::vector<int> touched(r.mesh.cells_around(tip).begin(), r.mesh.cells_around(tip).end());
  const double before = r.mesh.worst_quality(touched);
  const auto flips = repair(r.mesh, r.track, touched, 0.2);
  EXPECT_GE(r.mesh.worst_quality(touched), before);
  EXPECT_LE(flips.size(), 20U);
}

TEST(LocalMesh, CopyOfTheCellsNearby) {
  const Mesh mesh(tissue(16, 12, 0.2));
  const int centre = node_at(mesh, {0.04, 0.03});
  const std::vector<int> nodes{centre};
  const LocalMesh copy(mesh, nodes);
  EXPECT_LT(copy.mesh().n_cells(), 60);
  EXPECT_EQ(copy.global(copy.local(centre)), centre);
  EXPECT_EQ(copy.local(node_at(mesh, {0, 0})), -1);
  EXPECT_EQ(copy.mesh().point(copy.local(centre)), mesh.point(centre));
  EXPECT_EQ(copy.mesh().cells_around(copy.local(centre)).size(), mesh.cells_around(centre).size());
  // The rim is locked, the edges at the centre are not.
  for (const int node : mesh.neighbours(centre)) {
    if (node == centre) continue;
    EXPECT_FALSE(copy.mesh().is_locked_edge(copy.local(centre), copy.local(node)));
  }
  int rim = 0;
  for (int node = 0; node < copy.mesh().n_nodes(); ++node) rim += copy.mesh().on_boundary(node);
  EXPECT_GT(rim, 5);
}

}  // namespace

}  // namespace stylet
