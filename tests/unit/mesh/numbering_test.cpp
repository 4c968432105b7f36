#include "stylet/mesh/numbering.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/rectangle.hpp"
#include "stylet/mesh/validate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace stylet {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

MeshData grid(int columns, int rows) {
  RectangleMesh p;
  p.width = columns;
  p.height = rows;
  p.columns = columns;
  p.rows = rows;
  return make_rectangle(p);
}

/// Two grids side by side that share no node.
MeshData two_pieces() {
  MeshData mesh = grid(9, 7);
  const MeshData other = mesh;
  const int n = mesh.n_nodes();
  for (int i = 0; i < n; ++i) {
    mesh.coordinates.push_back(other.coordinates[2 * i] + 100);
    mesh.coordinates.push_back(other.coordinates[2 * i + 1]);
  }
  for (int node : other.cells) mesh.cells.push_back(node + n);
  mesh.cell_region.resize(2 * other.cell_region.size(), 0);
  return mesh;
}

void expect_valid(const MeshData& mesh, const Numbering& numbering, int n_ranks) {
  std::vector<int> sorted = numbering.new_of_old;
  std::ranges::sort(sorted);
  std::vector<int> all(mesh.n_nodes());
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(sorted, all);
  ASSERT_EQ(numbering.first_node.size(), static_cast<std::size_t>(n_ranks) + 1);
  EXPECT_EQ(numbering.first_node.front(), 0);
  EXPECT_EQ(numbering.first_node.back(), mesh.n_nodes());
  for (int r = 0; r < n_ranks; ++r) {
    const int owned = numbering.first_node[r + 1] - numbering.first_node[r];
    // METIS allows 3 % imbalance; a few nodes more on small meshes.
    EXPECT_NEAR(owned, mesh.n_nodes() / n_ranks, 0.04 * mesh.n_nodes() / n_ranks + 2);
  }
}

int bandwidth(const MeshData& mesh) {
  int widest = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto [low, high] =
        std::minmax({mesh.cells[3 * c], mesh.cells[3 * c + 1], mesh.cells[3 * c + 2]});
    widest = std::max(widest, high - low);
  }
  return widest;
}

TEST(Numbering, IsABalancedPermutation) {
  for (const MeshData& mesh : {grid(40, 30), two_pieces(), grid(2, 1)}) {
    for (int n_ranks : {1, 2, 3}) {
      expect_valid(mesh, number_nodes(mesh, n_ranks), n_ranks);
    }
  }
}

TEST(Numbering, IsDeterministic) {
  const MeshData mesh = grid(40, 30);
  const Numbering first = number_nodes(mesh, 3);
  std::srand(7);  // METIS must not depend on what ran before
  number_nodes(grid(5, 5), 2);
  const Numbering second = number_nodes(mesh, 3);
  EXPECT_EQ(first.new_of_old, second.new_of_old);
  EXPECT_EQ(first.first_node, second.first_node);
}

TEST(Numbering, NarrowsTheMatrix) {
  // A shuffled long strip: levels of Cuthill-McKee across it hold about 5 nodes.
  MeshData mesh = grid(200, 4);
  Numbering shuffle;
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    shuffle.new_of_old.push_back(static_cast<int>(i * 7919LL % mesh.n_nodes()));  // 7919 is prime
  }
  std::vector<int> old_cell;
  mesh = renumber(mesh, shuffle, old_cell);
  EXPECT_GT(bandwidth(mesh), 500);
  mesh = renumber(mesh, number_nodes(mesh, 1), old_cell);
  EXPECT_LT(bandwidth(mesh), 20);
}

TEST(Numbering, RenumberedMeshIsTheSameMesh) {
  MeshData mesh = grid(12, 9);
  const Numbering numbering = number_nodes(mesh, 3);
  std::vector<int> old_cell;
  MeshData result = renumber(mesh, numbering, old_cell);
  int previous = 0;
  for (int c = 0; c < result.n_cells(); ++c) {
    const int* nodes = &result.cells[3 * c];
    const int smallest = std::min({nodes[0], nodes[1], nodes[2]});
    EXPECT_GE(smallest, previous);
    previous = smallest;
    for (int k = 0; k < 3; ++k) {
      const int old = mesh.cells[3 * old_cell[c] + k];
      EXPECT_EQ(nodes[k], numbering.new_of_old[old]);
      EXPECT_EQ(result.coordinates[2 * nodes[k]], mesh.coordinates[2 * old]);
    }
  }
  EXPECT_EQ(result.facet_curve, mesh.facet_curve);
  EXPECT_NO_THROW(validate(result));
}

TEST(Numbering, Tetrahedra) {
  MeshData mesh;
  mesh.dim = 3;
  mesh.source = "pair";
  mesh.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  mesh.cells = {0, 1, 2, 3, 1, 2, 3, 4};
  mesh.cell_region = {0, 0};
  mesh.region_names = {"a"};
  expect_valid(mesh, number_nodes(mesh, 2), 2);
}

TEST(Numbering, Errors) {
  const MeshData mesh = grid(1, 1);
  EXPECT_THAT([&] { number_nodes(mesh, 0); },
              ThrowsMessage<InputError>(HasSubstr("0 ranks; allowed: 1 to 4")));
  EXPECT_THAT([&] { number_nodes(mesh, 5); },
              ThrowsMessage<InputError>(HasSubstr("5 ranks; allowed: 1 to 4")));
}

}  // namespace
}  // namespace stylet
