#include "stylet/mesh/mesh.hpp"

#include "stylet/base/errors.hpp"

#include "small_meshes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <vector>

namespace stylet {

namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<int> list(std::span<const int> values) {
  return {values.begin(), values.end()};
}

TEST(Mesh, WhoTouchesWhom) {
  const Mesh mesh(square());
  EXPECT_THAT(list(mesh.cells_around(0)), ElementsAre(0, 1));
  EXPECT_THAT(list(mesh.cells_around(1)), ElementsAre(0));
  EXPECT_THAT(mesh.neighbours(1), ElementsAre(0, 1, 2));
  EXPECT_EQ(mesh.across(0, 0, 2), 1);
  EXPECT_EQ(mesh.across(0, 0, 1), std::nullopt);
  EXPECT_THAT(mesh.cells_with(2, 0), ElementsAre(0, 1));
  EXPECT_THAT(mesh.cells_with(1, 3), ElementsAre());
  EXPECT_EQ(mesh.opposite(1, 2, 0), 3);
}

TEST(Mesh, BoundaryAndLocks) {
  RectangleMesh p;
  p.width = p.height = 1;
  p.columns = p.rows = 4;
  p.curves.push_back({"line", {{0.5, 0.25}, {0.5, 0.75}}});
  Mesh mesh(make_rectangle(p));
  const auto line = mesh.nodes_of("line");
  ASSERT_EQ(line.size(), 3U);
  EXPECT_FALSE(mesh.on_boundary(line[1]));
  EXPECT_FALSE(mesh.is_locked(line[1]));
  EXPECT_FALSE(mesh.is_locked_edge(line[0], line[1]));
  mesh.lock_curve("line");
  EXPECT_TRUE(mesh.is_locked(line[1]));
  EXPECT_TRUE(mesh.is_locked_edge(line[1], line[0]));
  const auto left = mesh.facets_of("left");
  EXPECT_EQ(left.size(), 4U);
  for (const int node : mesh.nodes_of("left")) EXPECT_TRUE(mesh.is_locked(node));
  EXPECT_TRUE(mesh.is_locked_edge(mesh.nodes_of("left")[0], mesh.nodes_of("left")[1]));
}

TEST(Mesh, EdgesBetweenRegionsAreLocked) {
  const Mesh mesh(shaken_rectangle());
  int between = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto n = mesh.cell(c);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto other = mesh.across(c, n[i], n[(i + 1) % 3]);
      const bool inner = other && mesh.region(*other) == mesh.region(c);
      EXPECT_EQ(mesh.is_locked_edge(n[i], n[(i + 1) % 3]), !inner);
      between += other && !inner ? 1 : 0;
    }
  }
  EXPECT_GT(between, 0);
}

TEST(Mesh, UnknownNamesListWhatThereIs) {
  const Mesh mesh(square());
  const auto message = [](auto&& lookup) -> std::string {
    try {
      lookup();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message([&] { (void)mesh.facets_of("top"); }), HasSubstr("bottom, right"));
  EXPECT_THAT(message([&] { (void)mesh.region_index("bone"); }), HasSubstr("tissue"));
  EXPECT_EQ(mesh.region_index("tissue"), 0);
}

TEST(Mesh, InvertedCellIsRefused) {
  MeshData data = square();
  std::swap(data.cells[0], data.cells[1]);
  EXPECT_THROW(Mesh{data}, InputError);
  data = square();
  data.coordinates[2] = 0;  // node 1 on the line from 0 to 2: no area
  data.coordinates[3] = 0;
  EXPECT_THROW(Mesh{data}, InputError);
}

TEST(Mesh, FlipAndBack) {
  Mesh mesh(square());
  const auto other = mesh.flip_edge(0, 2);
  EXPECT_EQ((std::set<int>{other[0], other[1]}), (std::set<int>{1, 3}));
  EXPECT_THAT(mesh.cells_with(0, 2), ElementsAre());
  EXPECT_THAT(mesh.cells_with(1, 3), ElementsAre(0, 1));
  EXPECT_THAT(list(mesh.cells_around(0)), testing::SizeIs(1));
  EXPECT_GT(mesh.cell_measure(0), 0);
  EXPECT_GT(mesh.cell_measure(1), 0);
  mesh.flip_edge(1, 3);
  EXPECT_THAT(mesh.cells_with(0, 2), ElementsAre(0, 1));
}

TEST(Mesh, EditsRaiseTheVersion) {
  Mesh mesh(square());
  const auto start = mesh.version();
  mesh.move_node(1, {1.1, 0});
  EXPECT_EQ(mesh.version(), start + 1);
  EXPECT_EQ(mesh.point(1), (ReferencePoint{1.1, 0}));
  mesh.flip_edge(0, 2);
  EXPECT_EQ(mesh.version(), start + 2);
}

TEST(Mesh, RandomFlipsKeepTheBooks) {
  Mesh mesh(shaken_rectangle());
  const double area = total_area(mesh);
  std::mt19937 random(3);
  int flips = 0;
  for (int i = 0; i < 300; ++i) {
    const int c = static_cast<int>(random() % static_cast<unsigned>(mesh.n_cells()));
    flips += flip_if_valid(mesh, mesh.cell(c)[0], mesh.cell(c)[1], 0.05) ? 1 : 0;
  }
  EXPECT_GT(flips, 50);
  // 144 areas, each with a few bits of round-off.
  EXPECT_NEAR(total_area(mesh), area, 1e-14);
  std::vector<std::vector<int>> around(static_cast<std::size_t>(mesh.n_nodes()));
  for (int c = 0; c < mesh.n_cells(); ++c) {
    EXPECT_GT(mesh.cell_measure(c), 0);
    for (const int node : mesh.cell(c)) around[static_cast<std::size_t>(node)].push_back(c);
  }
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    EXPECT_EQ(list(mesh.cells_around(node)), around[static_cast<std::size_t>(node)]);
  }
}

TEST(Mesh, WorstQuality) {
  Mesh mesh(square());
  const std::array<int, 2> both{0, 1};
  EXPECT_DOUBLE_EQ(mesh.worst_quality(both), mesh.cell_quality(0));
  mesh.move_node(3, {0.45, 0.55});
  EXPECT_LT(mesh.cell_quality(1), 0.3);
  EXPECT_EQ(mesh.worst_quality(both), mesh.cell_quality(1));
}

TEST(Mesh, Tetrahedron) {
  MeshData data;
  data.dim = 3;
  data.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  data.cells = {0, 1, 2, 3};
  data.cell_region = {0};
  data.region_names = {"tissue"};
  EXPECT_DOUBLE_EQ(Mesh(data).cell_measure(0), 1.0 / 6);
}

}  // namespace

}  // namespace stylet
