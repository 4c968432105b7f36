#include "stylet/mesh/embedded_point.hpp"

#include "stylet/mesh/refine.hpp"

#include "small_meshes.hpp"
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace stylet {

namespace {

// Barycentric coordinates of cells of unit aspect: a few operations.
constexpr double round_off = 1e-13;

void expect_holds(const Mesh& mesh, const EmbeddedPoint& point, double outside = 1e-9) {
  ReferencePoint x{0, 0};
  const auto nodes = mesh.cell(point.cell);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GE(point.weights[i], -outside);  // what counts as inside (embedded_point.cpp)
    x.x += point.weights[i] * mesh.point(nodes[i]).x;
    x.y += point.weights[i] * mesh.point(nodes[i]).y;
  }
  EXPECT_NEAR(x.x, point.x.x, round_off);
  EXPECT_NEAR(x.y, point.x.y, round_off);
}

std::vector<EmbeddedPoint> random_points(const Mesh& mesh, int n) {
  std::mt19937 random(5);
  const auto share = [&] { return static_cast<double>(random()) / random.max(); };
  std::vector<EmbeddedPoint> points;
  int hint = 0;
  for (int i = 0; i < n; ++i) {
    const double x = 2 * share();
    const auto found = locate(mesh, {x, share()}, hint);
    EXPECT_TRUE(found);
    if (!found) continue;
    points.push_back(*found);
    hint = found->cell;
  }
  return points;
}

TEST(EmbeddedPoint, RandomPointsFromAnyHint) {
  const Mesh mesh(shaken_rectangle());
  for (const auto& point : random_points(mesh, 200)) expect_holds(mesh, point);
}

TEST(EmbeddedPoint, NodesAndEdges) {
  const Mesh mesh(shaken_rectangle());
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const auto found = locate(mesh, mesh.point(node));
    ASSERT_TRUE(found);
    expect_holds(mesh, *found);
    EXPECT_TRUE(std::ranges::count(mesh.cells_around(node), found->cell) == 1);
  }
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto n = mesh.cell(c);
    const auto found = locate(mesh, midpoint(mesh.point(n[0]), mesh.point(n[1])));
    ASSERT_TRUE(found);
    EXPECT_TRUE(std::ranges::count(mesh.cells_with(n[0], n[1]), found->cell) == 1);
  }
}

TEST(EmbeddedPoint, OutsideIsNone) {
  const Mesh mesh(shaken_rectangle());
  EXPECT_FALSE(locate(mesh, {-0.01, 0.5}));
  EXPECT_FALSE(locate(mesh, {1, 1.0001}));
  EXPECT_FALSE(locate(mesh, {5, 5}));
}

TEST(EmbeddedPoint, WalkAroundACorner) {
  // A long L without its inner corner: the straight walk leaves the tissue.
  MeshData data;
  const int n = 8;
  const auto number = [&](int i, int j) { return i * (n + 1) + j; };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j)
      data.coordinates.insert(data.coordinates.end(), {1.0 * i, 1.0 * j});
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      if (i >= 1 && j >= 1) continue;
      const int a = number(i, j);
      const int b = number(i + 1, j);
      const int c = number(i + 1, j + 1);
      const int d = number(i, j + 1);
      data.cells.insert(data.cells.end(), {a, b, c, a, c, d});
      data.cell_region.insert(data.cell_region.end(), {0, 0});
    }
  }
  data.region_names = {"tissue"};
  const Mesh mesh(data);
  int far = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (mesh.point(mesh.cell(c)[0]).x > mesh.point(mesh.cell(far)[0]).x) far = c;
  }
  const auto found = locate(mesh, {0.4, 7.7}, far);
  ASSERT_TRUE(found);
  expect_holds(mesh, *found);
  EXPECT_FALSE(locate(mesh, {4, 4}, far));
}

TEST(EmbeddedPoint, RelocateAfterMovesAndFlips) {
  Mesh mesh(shaken_rectangle());
  auto points = random_points(mesh, 100);
  const auto before = points;
  std::mt19937 random(11);
  for (int i = 0; i < 200; ++i) {
    const int node = static_cast<int>(random() % static_cast<unsigned>(mesh.n_nodes()));
    if (mesh.is_locked(node)) continue;
    const ReferencePoint from = mesh.point(node);
    const auto shift = [&] { return 0.1 * (static_cast<double>(random()) / random.max() - 0.5); };
    const double dx = shift();
    mesh.move_node(node, from + Vector2{dx, shift()});
    auto around = mesh.cells_around(node);
    std::vector<int> touched(around.begin(), around.end());
    if (!(mesh.worst_quality(touched) > 0.05)) mesh.move_node(node, from);
    const int a = mesh.cell(touched[0])[0];
    const int b = mesh.cell(touched[0])[1];
    const auto both = mesh.cells_with(a, b);
    if (flip_if_valid(mesh, a, b, 0.05)) touched.insert(touched.end(), both.begin(), both.end());
    relocate(mesh, touched, points);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(points[i].x, before[i].x);  // fixed in the reference frame
    expect_holds(mesh, points[i]);
  }
}

TEST(EmbeddedPoint, UntouchedPointsStay) {
  Mesh mesh(square());
  std::vector<EmbeddedPoint> points{*locate(mesh, {0.9, 0.2}), *locate(mesh, {0.1, 0.8})};
  ASSERT_EQ(points[0].cell, 0);
  ASSERT_EQ(points[1].cell, 1);
  mesh.move_node(3, {-0.5, 1});
  const std::vector<int> touched{1};
  relocate(mesh, touched, points);
  EXPECT_EQ(points[0].weights, locate(mesh, {0.9, 0.2})->weights);
  expect_holds(mesh, points[1]);
}

TEST(EmbeddedPoint, RoundOffBesideTheBoundaryIsInside) {
  // Of the extent, not of the elements: the same on every mesh.
  for (const int refinements : {0, 3}) {
    const Mesh mesh(refine(shaken_rectangle(), refinements));
    const auto found = locate(mesh, {2 + 1e-8, 0.4});
    ASSERT_TRUE(found);
    expect_holds(mesh, {found->x, found->cell, found->weights}, 1e-6);
    EXPECT_TRUE(locate(mesh, {-1e-8, 1 + 1e-8}));
    EXPECT_FALSE(locate(mesh, {2 + 1e-7, 0.4}));
    EXPECT_FALSE(locate(mesh, {1, -1e-7}));
  }
}

}  // namespace

}  // namespace stylet
