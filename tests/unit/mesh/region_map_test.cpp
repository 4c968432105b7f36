#include "stylet/mesh/region_map.hpp"

#include "small_meshes.hpp"
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace stylet {

namespace {

double share_of(const std::vector<std::pair<int, double>>& shares, int region) {
  const auto found = std::ranges::find(shares, region, &std::pair<int, double>::first);
  return found == shares.end() ? 0 : found->second;
}

double sum(const std::vector<std::pair<int, double>>& shares) {
  return std::accumulate(shares.begin(), shares.end(), 0.0,
                         [](double s, const auto& share) { return s + share.second; });
}

TEST(RegionMap, UneditedCellIsItsOwnRegion) {
  const Mesh mesh(shaken_rectangle());
  const RegionMap map(mesh);
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto shares = map.shares(mesh, c);
    ASSERT_EQ(shares.size(), 1U) << c;
    EXPECT_EQ(shares[0], (std::pair{mesh.region(c), 1.0}));
  }
}

TEST(RegionMap, MovedNodeMixes) {
  // Two regions that meet at x = 1; the middle node goes over to the right by half a column.
  MeshData data;
  data.coordinates = {0, 0, 1, 0, 2, 0, 0, 1, 1, 1, 2, 1};
  data.cells = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4};
  data.cell_region = {0, 0, 1, 1};
  data.region_names = {"left", "right"};
  Mesh mesh(data);
  const RegionMap map(mesh);
  mesh.move_node(1, {1.5, 0});
  // Cell 0 = (0, 0), (1.5, 0), (1, 1): right of x = 1 lies 0.25 of 0.75.
  const auto shares = map.shares(mesh, 0);
  EXPECT_NEAR(sum(shares), 1, 1e-15);
  EXPECT_NEAR(share_of(shares, 1), 1.0 / 3, 1e-15);
  EXPECT_EQ(share_of(map.shares(mesh, 2), 1), 1);  // still all right
  mesh.move_node(1, {0.5, 0});
  // Cell 2 = (0.5, 0), (2, 0), (2, 1): left of x = 1 lies a sixth of the base times a third.
  EXPECT_NEAR(share_of(map.shares(mesh, 2), 0), 1.0 / 9, 1e-15);
}

TEST(RegionMap, SharesAreContinuousInTheNodes) {
  MeshData data;
  data.coordinates = {0, 0, 1, 0, 2, 0, 0, 1, 1, 1, 2, 1};
  data.cells = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4};
  data.cell_region = {0, 0, 1, 1};
  data.region_names = {"left", "right"};
  Mesh mesh(data);
  const RegionMap map(mesh);
  double last = 0;
  constexpr int n = 1000;
  for (int i = 1; i < n; ++i) {
    mesh.move_node(1, {1 + 0.8 * i / n, 0});
    const double share = share_of(map.shares(mesh, 0), 1);
    EXPECT_GE(share, last);
    EXPECT_LT(share - last, 1.0 / n);  // 1 - 1/x right of x = 1, so its slope is at most 1
    last = share;
  }
}

TEST(RegionMap, SharesOfTheWholeKeepTheArea) {
  Mesh mesh(shaken_rectangle());
  const RegionMap map(mesh);
  const int core = mesh.region_index("core");
  double before = 0;
  for (int c = 0; c < mesh.n_cells(); ++c)
    before += mesh.region(c) == core ? mesh.cell_measure(c) : 0;
  // The nodes of a row across the ellipse go a third of a square to the side.
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    if (mesh.is_locked(node) || std::abs(mesh.point(node).y - 0.5) > 0.05) continue;
    mesh.move_node(node, mesh.point(node) + Vector2{0.05, 0});
  }
  double after = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    ASSERT_GT(mesh.cell_measure(c), 0);
    after += share_of(map.shares(mesh, c), core) * mesh.cell_measure(c);
  }
  EXPECT_NEAR(after, before, 1e-14);
}

}  // namespace

}  // namespace stylet
