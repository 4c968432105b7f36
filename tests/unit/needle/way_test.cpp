// The direction of the tip and the element ahead.
#include "stylet/needle/advance.hpp"

#include "bench.hpp"
#include <gtest/gtest.h>

#include <cmath>

namespace stylet {

namespace {

const Axis axis{0.03};

/// Skin node, then a tip 1 cm deep, both on nodes of the grid.
Track two_nodes(const Mesh& mesh) {
  Track track;
  track.push({node_at(mesh, {0.08, 0.03})});
  track.push({node_at(mesh, {0.07, 0.03})});
  return track;
}

/// u = (F - 1)(x - c): the tip at c stays in place.
Displacement homogeneous(double xx, double xy, double yx, double yy) {
  return [=](ReferencePoint x) {
    const Vector2 d = x - ReferencePoint{0.07, 0.03};
    return Vector2{(xx - 1) * d.x + xy * d.y, yx * d.x + (yy - 1) * d.y};
  };
}

TEST(Way, AlongAnEdgeTakesTheHigherElement) {
  for (const auto diagonals : {Diagonals::alternating, Diagonals::one_way}) {
    const Mesh mesh(tissue(8, 6, 0, diagonals));
    const auto way = find_way(mesh, two_nodes(mesh), axis, still(mesh));
    ASSERT_TRUE(way);
    EXPECT_EQ(way->r, (Vector2{-1, 0}));
    EXPECT_FALSE(way->fell_back);
    // One division of numbers of 1 cm.
    EXPECT_NEAR(way->distance, 0.01, 1e-17);
    const double highest = std::max(mesh.point(way->j).y, mesh.point(way->k).y);
    EXPECT_GT(highest, 0.035);
  }
}

TEST(Way, FInverseKeepsTheTipOnTheAxis) {
  const Mesh mesh(tissue(8, 6, 0.2));
  Track track;
  track.push({node_at(mesh, {0.08, 0.03})});
  track.push({node_at(mesh, {0.07, 0.03})});
  const ReferencePoint p = mesh.point(track.tip());
  const double f[2][2] = {{0.8, 0.15}, {-0.1, 1.1}};
  const Displacement u = [&](ReferencePoint x) {
    const Vector2 d = x - p;
    return Vector2{(f[0][0] - 1) * d.x + f[0][1] * d.y, f[1][0] * d.x + (f[1][1] - 1) * d.y};
  };
  const auto way = find_way(mesh, track, {p.y}, view_of(mesh, u));
  ASSERT_TRUE(way);
  EXPECT_FALSE(way->fell_back);
  // F r is parallel to d; round-off of gradients of some cells, relative to one.
  EXPECT_NEAR(f[1][0] * way->r.x + f[1][1] * way->r.y, 0, 1e-12);
  EXPECT_NEAR(norm(way->r), 1, 1e-15);
  const double stretch = -(f[0][0] * way->r.x + f[0][1] * way->r.y);
  for (const double share : {0.1, 0.5, 1.0}) {
    const double b = share * way->distance;
    const NodeEdit edit = advanced(*way, track.tip(), b);
    const WorldPoint x = displaced(edit.x, edit.state.u);
    EXPECT_NEAR(x.y, p.y, 1e-15);                // still on the axis (m)
    EXPECT_NEAR(x.x, p.x - b * stretch, 1e-15);  // forward by F r b
  }
}

TEST(Way, FallsBackWhereFIsNoHelp) {
  const Mesh mesh(tissue(8, 6));
  const Track track = two_nodes(mesh);
  const auto way_in = [&](const Displacement& u) {
    return find_way(mesh, track, axis, view_of(mesh, u));
  };
  // Squeezed to 4 % of its area; turned by 100 degrees; turned inside out.
  const double c = std::cos(100 * M_PI / 180);
  const double s = std::sin(100 * M_PI / 180);
  for (const auto& u :
       {homogeneous(0.2, 0, 0, 0.2), homogeneous(c, -s, s, c), homogeneous(-1, 0, 0, 1)}) {
    const auto way = way_in(u);
    ASSERT_TRUE(way);
    EXPECT_TRUE(way->fell_back);
    EXPECT_EQ(way->r, (Vector2{-1, 0}));
  }
  EXPECT_FALSE(way_in(homogeneous(0.4, 0, 0, 0.4))->fell_back);
}

TEST(Way, NoneAtTheFarBoundary) {
  const Mesh mesh(tissue(8, 6));
  Track track;
  track.push({node_at(mesh, {0.01, 0.03})});
  track.push({node_at(mesh, {0, 0.03})});
  EXPECT_FALSE(find_way(mesh, track, axis, still(mesh)));
}

TEST(Way, HandOverWhereTheLastEdgeIsTwiceTheDistanceAhead) {
  const Mesh mesh(tissue(8, 6, 0.2));
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    if (mesh.is_locked(node)) continue;
    for (const int behind : mesh.neighbours(node)) {
      if (mesh.point(behind).x <= mesh.point(node).x + 1e-3) continue;
      Track track;
      track.push({behind});
      track.push({node});
      const auto way = find_way(mesh, track, {mesh.point(node).y}, still(mesh));
      ASSERT_TRUE(way);
      const ReferencePoint q = way->p + way->hand_over * way->r;
      const double last = distance(mesh.point(behind), q);
      // A square root of numbers of 1e-4 m2.
      EXPECT_NEAR(last, 2 * (way->distance - way->hand_over), 1e-14);
      EXPECT_LT(way->hand_over, way->distance);
      EXPECT_LT(way->reach, way->distance);
    }
  }
}

TEST(Way, ReachKeepsTheElementsBesideValid) {
  Mesh mesh(tissue(8, 6, 0.25));
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    if (mesh.is_locked(node)) continue;
    Track track;
    track.push({node_at(mesh, mesh.point(node) + Vector2{0.01, 0})});
    track.push({node});
    const auto way = find_way(mesh, track, {mesh.point(node).y}, still(mesh));
    ASSERT_TRUE(way);
    const ReferencePoint from = mesh.point(node);
    for (const double share : {0.25, 0.5, 0.75, 1.0}) {
      mesh.move_node(node, from + share * way->reach * way->r);
      EXPECT_GT(mesh.worst_quality(mesh.cells_around(node)), 0.03);
    }
    mesh.move_node(node, from);
  }
}

TEST(Way, SameInEveryNumbering) {
  for (const double jitter : {0.0, 0.2}) {  // without jitter every decision is a tie
    const MeshData data = tissue(8, 6, jitter);
    const Mesh plain(data);
    for (unsigned seed = 1; seed < 6; ++seed) {
      const Mesh other = permuted(data, seed);
      for (int node = 0; node < plain.n_nodes(); ++node) {
        if (plain.is_locked(node)) continue;
        const auto way_in = [&](const Mesh& mesh) {
          Track track;
          track.push({node_at(mesh, plain.point(node) + Vector2{0.01, 0})});
          track.push({node_at(mesh, plain.point(node))});
          const auto way = find_way(mesh, track, {plain.point(node).y}, still(mesh));
          EXPECT_TRUE(way);
          return *way;
        };
        const auto a = way_in(plain);
        const auto b = way_in(other);
        // The same element; cells in another cyclic order round differently.
        EXPECT_EQ(plain.point(a.j), other.point(b.j));
        EXPECT_EQ(plain.point(a.k), other.point(b.k));
        EXPECT_NEAR(a.distance, b.distance, 1e-16);
        EXPECT_NEAR(a.hand_over, b.hand_over, 1e-15);
      }
    }
  }
}

}  // namespace

}  // namespace stylet
