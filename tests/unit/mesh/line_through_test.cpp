// Lines through tetrahedra, and the grid that finds them.
#include "stylet/mesh/line_through.hpp"

#include "stylet/mesh/box.hpp"
#include "stylet/mesh/cell_grid.hpp"

#include <gtest/gtest.h>

#include <random>

namespace stylet {
namespace {

BoxMesh brick(double jitter) {
  BoxMesh p;
  p.width = 3;
  p.height = 2;
  p.depth = 1;
  p.columns = 6;
  p.rows = 4;
  p.layers = 2;
  p.jitter = jitter;
  return p;
}

Vector3 unit(Vector3 v) {
  return 1 / norm(v) * v;
}

void expect_stretch(const Mesh& mesh, ReferencePlace start, Vector3 d, double from, double to) {
  const auto stretch = first_stretch(mesh, start, unit(d));
  ASSERT_TRUE(stretch);
  EXPECT_NEAR(stretch->from, from, 1e-14);
  EXPECT_NEAR(stretch->to, to, 1e-14);
}

TEST(LineThrough, NodesEdgesFacesAndCells) {
  for (const double jitter : {0.0, 0.2}) {
    const Mesh mesh(make_box(brick(jitter)));
    expect_stretch(mesh, {-1, 1, 0.5}, {1, 0, 0}, 1, 4);            // without jitter along edges
    expect_stretch(mesh, {-1, 1.2, 0.5}, {1, 0, 0}, 1, 4);          // within faces
    expect_stretch(mesh, {-1, 1.23, 0.37}, {1, 0, 0}, 1, 4);        // through cells
    expect_stretch(mesh, {-1, 0, 0}, {1, 0, 0}, 1, 4);              // an edge of the box
    expect_stretch(mesh, {1.3, 1.1, 0.2}, {0, -1, 0}, 0, 1.1);      // from inside
    expect_stretch(mesh, {0, 1, 0}, {1, 0, 1}, 0, std::sqrt(2.0));  // from a node of the skin
  }
}

TEST(LineThrough, WhatMissesOrTouches) {
  const Mesh mesh(make_box(brick(0)));
  EXPECT_FALSE(first_stretch(mesh, {-1, 2.1, 0.5}, {1, 0, 0}));
  EXPECT_FALSE(first_stretch(mesh, {4, 1, 0.5}, {1, 0, 0}));
  EXPECT_FALSE(first_stretch(mesh, {-1, 1, 0.5}, unit({-1, 0, 0})));
  EXPECT_FALSE(first_stretch(mesh, {-1, 1, 0.5}, unit({1, 1.2, 0})));
  // An edge of the box, at a node and beside one.
  EXPECT_FALSE(first_stretch(mesh, {-1, 1, 0.5}, unit({1, -1, 0})));
  EXPECT_FALSE(first_stretch(mesh, {-1, 1, 0.3}, unit({1, -1, 0})));
}

// Two towers on a floor: the line leaves the first one before it enters the other.
TEST(LineThrough, EndsWhereItLeavesATissueThatIsNotConvex) {
  MeshData data = make_box(brick(0));
  MeshData cut = data;
  cut.cells.clear();
  cut.cell_region.clear();
  for (int c = 0; c < data.n_cells(); ++c) {
    double x = 0;
    double y = 0;
    for (int k = 0; k < 4; ++k) {
      const auto node = static_cast<std::size_t>(data.cells[static_cast<std::size_t>(4 * c + k)]);
      x += data.coordinates[3 * node] / 4;
      y += data.coordinates[3 * node + 1] / 4;
    }
    if (x > 1 && x < 2 && y > 1) continue;
    const auto first = data.cells.begin() + 4 * c;
    cut.cells.insert(cut.cells.end(), first, first + 4);
    cut.cell_region.push_back(0);
  }
  const Mesh mesh(cut);
  expect_stretch(mesh, {-1, 1.7, 0.3}, {1, 0, 0}, 1, 2);
  expect_stretch(mesh, {1.5, 1.7, 0.3}, {1, 0, 0}, 0.5, 1.5);
  expect_stretch(mesh, {-1, 0.7, 0.3}, {1, 0, 0}, 1, 4);
}

TEST(CellGrid, FindsWhatTheWalkFinds) {
  const Mesh mesh(make_box(brick(0.25)));
  const CellGrid grid(mesh, {-0.2, -0.2, -0.2}, {2.1, 2.5, 1.5}, 0.4);
  std::mt19937 bits(3);
  const auto uniform = [&] { return static_cast<double>(bits()) / 4294967296.0; };
  int inside = 0;
  for (int i = 0; i < 2000; ++i) {
    const ReferencePlace x{-0.2 + 2.2 * uniform(), -0.2 + 2.6 * uniform(), -0.2 + 1.6 * uniform()};
    const auto found = grid.find(x);
    const auto walked = locate(mesh, x);
    ASSERT_EQ(found.has_value(), walked.has_value());
    if (!found) continue;
    ++inside;
    EXPECT_EQ(found->cell, walked->cell);
    EXPECT_EQ(found->weights, walked->weights);
  }
  EXPECT_GT(inside, 500);
  EXPECT_FALSE(grid.find({2.9, 1, 0.5}));  // beyond the grid
}

}  // namespace
}  // namespace stylet
