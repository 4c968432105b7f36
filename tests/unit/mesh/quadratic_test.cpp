#include "stylet/mesh/quadratic.hpp"

#include "stylet/mesh/box.hpp"
#include "stylet/mesh/embedded_point.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/numbering.hpp"
#include "stylet/mesh/refine.hpp"

#include <gtest/gtest.h>

#include <set>

namespace stylet {
namespace {

MeshData shaken_box() {
  BoxMesh p;
  p.width = 3;
  p.height = 2;
  p.depth = 2;
  p.columns = 3;
  p.rows = 2;
  p.layers = 2;
  p.jitter = 0.2;
  return make_box(p);
}

void expect_middles(const Mesh& mesh) {
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto nodes = mesh.nodes(c);
    ASSERT_EQ(nodes.size(), 10);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(nodes[k], mesh.cell(c)[k]);
    for (std::size_t e = 0; e < 6; ++e) {
      const auto [a, b] = tetrahedron_edges[e];
      const ReferencePlace x = mesh.place(nodes[a]);
      EXPECT_LT(distance(mesh.place(nodes[4 + e]), x + 0.5 * (mesh.place(nodes[b]) - x)), 1e-15);
    }
  }
}

TEST(Quadratic, NodesStandInTheMiddleOfEdgesOnAnyNumberOfRanks) {
  MeshData data = shaken_box();
  // The corners and middles of a box of bricks with six tetrahedra each are twice as fine a grid.
  add_mid_edge_nodes(data);
  EXPECT_EQ(data.n_nodes(), 7 * 5 * 5);
  expect_middles(Mesh(data));
  for (const int n_ranks : {1, 2, 3}) {
    const Numbering numbering = number_nodes(data, n_ranks);
    std::vector<int> old_cell;
    const Mesh mesh(renumber(data, numbering, old_cell));
    expect_middles(mesh);
    std::set<int> numbers(numbering.new_of_old.begin(), numbering.new_of_old.end());
    EXPECT_EQ(numbers.size(), static_cast<std::size_t>(data.n_nodes()));
  }
}

TEST(Quadratic, SurfacesHaveAllNodesOnThem) {
  MeshData data = refine(shaken_box(), 1);
  add_mid_edge_nodes(data);
  const Mesh mesh(std::move(data));
  const auto left = mesh.nodes_of("left");
  int on_left = 0;
  int outer = 0;
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const ReferencePlace x = mesh.place(node);
    if (std::abs(x.x) < 1e-12) ++on_left;
    const bool is_outer = std::min({x.x, x.y, x.z, 3 - x.x, 2 - x.y, 2 - x.z}) < 1e-12;
    EXPECT_EQ(mesh.on_boundary(node), is_outer);
    outer += is_outer ? 1 : 0;
  }
  EXPECT_EQ(left.size(), static_cast<std::size_t>(on_left));
  EXPECT_EQ(outer, 13 * 9 * 9 - 11 * 7 * 7);
}

TEST(Quadratic, ShapeFunctionsReproduceQuadratics) {
  MeshData data = shaken_box();
  add_mid_edge_nodes(data);
  const Mesh mesh(std::move(data));
  const auto field = [](ReferencePlace x) {
    return 1 + x.x - 2 * x.y * x.z + x.z * x.z + 3 * x.x * x.y;
  };
  for (const ReferencePlace x : {ReferencePlace{0.3, 0.7, 1.1}, {2.9, 1.3, 0.2}, {1, 1, 1}}) {
    double sum = 0;
    double ones = 0;
    for (const auto& [node, weight] : node_weights(mesh, *locate(mesh, x))) {
      sum += weight * field(mesh.place(node));
      ones += weight;
    }
    EXPECT_NEAR(sum, field(x), 1e-13);
    EXPECT_NEAR(ones, 1, 1e-14);
  }
}

}  // namespace
}  // namespace stylet
