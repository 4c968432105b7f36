#include "stylet/mesh/refine.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/rectangle.hpp"
#include "stylet/mesh/validate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace stylet {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

MeshData coarse_mesh() {
  RectangleMesh p;
  p.width = 2;
  p.height = 1;
  p.columns = 6;
  p.rows = 4;
  p.jitter = 0.2;
  p.inner_regions = {
      {"core", std::vector<ReferencePoint>{{0.4, 0.3}, {1.5, 0.2}, {1.4, 0.8}, {0.5, 0.7}}}};
  return make_rectangle(p);
}

TEST(Refine, CountsAndNumbers) {
  const MeshData coarse = coarse_mesh();
  MeshData fine = refine(coarse, 1);
  EXPECT_EQ(fine.n_cells(), 4 * coarse.n_cells());
  EXPECT_EQ(fine.n_facets(), 2 * coarse.n_facets());
  // Euler: edges = nodes + cells - 1 for a disc; one new node an edge.
  EXPECT_EQ(fine.n_nodes(), 2 * coarse.n_nodes() + coarse.n_cells() - 1);
  EXPECT_TRUE(
      std::equal(coarse.coordinates.begin(), coarse.coordinates.end(), fine.coordinates.begin()));
  EXPECT_EQ(fine.region_names, coarse.region_names);
  EXPECT_NO_THROW(validate(fine));
  EXPECT_EQ(refine(coarse, 0).cells, coarse.cells);
  EXPECT_EQ(refine(coarse, 2).cells, refine(fine, 1).cells);
}

TEST(Refine, ChildrenTileTheirParent) {
  const Mesh coarse(coarse_mesh());
  const Mesh fine(refine(coarse.data(), 1));
  for (int c = 0; c < coarse.n_cells(); ++c) {
    const auto t = coarse.cell(c);
    const double area = coarse.cell_measure(c);
    for (int child = 4 * c; child < 4 * c + 4; ++child) {
      EXPECT_NEAR(fine.cell_measure(child), area / 4, 1e-14);  // rounding of lengths near 1
      EXPECT_EQ(fine.region(child), coarse.region(c));
      for (int node : fine.cell(child)) {
        for (double l : barycentric(coarse.point(t[0]), coarse.point(t[1]), coarse.point(t[2]),
                                    fine.point(node))) {
          EXPECT_GT(l, -1e-12);  // a corner or an edge of the parent
        }
      }
    }
  }
}

TEST(Refine, CurvesKeepTheirLengthAndDirection) {
  const MeshData coarse = coarse_mesh();
  const MeshData fine = refine(coarse, 3);
  for (const MeshData* mesh : {&coarse, &fine}) {
    std::vector<double> length(mesh->curve_names.size(), 0);
    for (int f = 0; f < mesh->n_facets(); ++f) {
      const int a = mesh->facets[2 * f];
      const int b = mesh->facets[2 * f + 1];
      length[mesh->facet_curve[f]] +=
          std::hypot(mesh->coordinates[2 * a] - mesh->coordinates[2 * b],
                     mesh->coordinates[2 * a + 1] - mesh->coordinates[2 * b + 1]);
    }
    EXPECT_NEAR(length[0], 1, 1e-13);  // left
    EXPECT_NEAR(length[2], 2, 1e-13);  // bottom
  }
  EXPECT_EQ(fine.facets[0], coarse.facets[0]);
  EXPECT_EQ(fine.facets[15], coarse.facets[1]);
}

TEST(Refine, Errors) {
  MeshData mesh = coarse_mesh();
  EXPECT_THAT([&] { refine(mesh, -1); },
              ThrowsMessage<InputError>(HasSubstr("rectangle: refine = -1; allowed: 0 or more")));
}

}  // namespace
}  // namespace stylet
