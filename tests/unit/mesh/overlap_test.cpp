// Meshes whose triangles lie on each other or do not hang together.
#include "stylet/mesh/overlap.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/mesh/rectangle.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Counter-clockwise triangles.
MeshData mesh_of(std::vector<double> coordinates, std::vector<int> cells) {
  MeshData mesh;
  mesh.source = "sheet";
  mesh.coordinates = std::move(coordinates);
  mesh.cells = std::move(cells);
  mesh.cell_region.assign(mesh.cells.size() / 3, 0);
  mesh.region_names = {"a"};
  return mesh;
}

std::string message_of(const MeshData& mesh) {
  try {
    check_overlaps(mesh);
    return "no error";
  } catch (const InputError& error) {
    return error.what();
  }
}

/// Two unit squares side by side; the right one begins at node 4.
MeshData squares(double from) {
  return mesh_of({0, 0, 1, 0, 1, 1, 0, 1, from, 0, from + 1, 0, from + 1, 1, from, 1},
                 {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7});
}

TEST(Overlap, GoodMeshesPass) {
  RectangleMesh rectangle;
  rectangle.width = 0.08;
  rectangle.height = 0.06;
  rectangle.columns = 37;
  rectangle.rows = 23;
  rectangle.jitter = 0.25;
  rectangle.inner_regions = {{"gland", Ellipse{{0.04, 0.03}, 0.03, 0.02}}};
  EXPECT_EQ(message_of(make_rectangle(rectangle)), "no error");
  // A ring: a boundary inside the other one.
  std::vector<double> x;
  std::vector<int> cells;
  constexpr int n = 40;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    for (const double r : {0.5, 1.0}) {
      x.push_back(r * std::cos(angle));
      x.push_back(r * std::sin(angle));
    }
    const int in = 2 * i;
    const int next = 2 * ((i + 1) % n);
    cells.insert(cells.end(), {in, in + 1, next + 1, in, next + 1, next});
  }
  EXPECT_EQ(message_of(mesh_of(x, cells)), "no error");
}

TEST(Overlap, PartsThatShareNoNode) {
  EXPECT_THAT(message_of(squares(1.5)), AllOf(HasSubstr("in parts that share no node"),
                                              HasSubstr("triangle 3 at (1.5, 0) m")));
  MeshData hinged = squares(1.5);
  for (int& node : hinged.cells) node = node == 4 ? 1 : node;
  EXPECT_THAT(message_of(hinged), HasSubstr("at a single node only, 2 at (1, 0) m"));
}

TEST(Overlap, DoubledInterfaces) {
  EXPECT_THAT(message_of(squares(1)), HasSubstr("nodes 2 and 5 are at the same place, (1, 0) m"));
  EXPECT_THAT(message_of(squares(1 + 1e-12)), HasSubstr("at the same place"));
  // The nodes of one side fall between those of the other.
  MeshData shifted = squares(1);
  for (const std::size_t node : {4, 5, 6, 7}) shifted.coordinates[2 * node + 1] += 0.3;
  EXPECT_THAT(message_of(shifted), HasSubstr("lies on an outer edge"));
}

TEST(Overlap, MessagesHaveTheNumbersOfTheFile) {
  const auto numbered = [](MeshData mesh) {
    for (int i = 0; i < mesh.n_nodes(); ++i) mesh.origin.node_number.push_back(1000 + 10 * i);
    for (int i = 0; i < mesh.n_cells(); ++i) mesh.origin.cell_number.push_back(500 + i);
    return message_of(mesh);
  };
  EXPECT_THAT(numbered(squares(1)), HasSubstr("nodes 1010 and 1040 are at the same place"));
  EXPECT_THAT(numbered(squares(1.5)), AllOf(HasSubstr("one has triangle 500 at (0, 0) m"),
                                            HasSubstr("another triangle 502 at (1.5, 0) m")));
  EXPECT_THAT(numbered(squares(0.6)), AllOf(HasSubstr("node 1"), HasSubstr("from node 1")));
  MeshData covered =
      mesh_of({0, 0, 1, 0, 1, 1, 0, 1, 0.5, 0.5}, {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 4, 0, 1});
  EXPECT_THAT(numbered(covered),
              AllOf(HasSubstr("overlap at node 1040"), HasSubstr("one of them is triangle 504")));
}

TEST(Overlap, TrianglesOnOthers) {
  EXPECT_THAT(message_of(squares(0.6)), HasSubstr("lies on an outer edge"));
  MeshData tilted = squares(0.6);
  tilted.coordinates[2 * 4 + 1] = -0.1;
  tilted.coordinates[2 * 7 + 1] = 1.1;
  EXPECT_THAT(message_of(tilted), HasSubstr("outer edges cross at ("));
  // A triangle over those around the middle of a square, with nodes of theirs.
  MeshData covered =
      mesh_of({0, 0, 1, 0, 1, 1, 0, 1, 0.5, 0.5}, {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 4, 0, 1});
  EXPECT_THAT(message_of(covered), HasSubstr("overlap at node 5 at (0.5, 0.5) m"));
  // A fan that turns twice around its middle.
  std::vector<double> x{0, 0};
  std::vector<int> cells;
  for (int i = 0; i < 12; ++i) {
    const double angle = 4 * std::numbers::pi * i / 12;
    const double r = i < 6 ? 1 : 1.5;
    x.push_back(r * std::cos(angle));
    x.push_back(r * std::sin(angle));
    cells.insert(cells.end(), {0, i + 1, (i + 1) % 12 + 1});
  }
  EXPECT_THAT(message_of(mesh_of(x, cells)),
              HasSubstr("overlap at node 1 at (0, 0) m: they turn around it more than once"));
}

}  // namespace
}  // namespace stylet
