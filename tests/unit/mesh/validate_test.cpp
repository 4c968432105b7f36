#include "stylet/mesh/validate.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/refine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace stylet {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// The unit square in four triangles around node 4, two regions of two.
MeshData square() {
  MeshData mesh;
  mesh.source = "square";
  mesh.coordinates = {0, 0, 1, 0, 1, 1, 0, 1, 0.5, 0.5};
  mesh.cells = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
  mesh.cell_region = {0, 0, 1, 1};
  mesh.region_names = {"a", "b"};
  mesh.facets = {0, 1, 4, 2};
  mesh.facet_curve = {0, 1};
  mesh.curve_names = {"bottom", "cut"};
  return mesh;
}

void expect_error(MeshData mesh, const std::string& part) {
  EXPECT_THAT([&mesh] { validate(mesh); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("square: "), HasSubstr(part))));
}

TEST(Validate, LeavesAGoodMeshAlone) {
  MeshData mesh = square();
  validate(mesh);
  EXPECT_EQ(mesh.cells, square().cells);
}

TEST(Validate, TurnsAClockwiseRegionRound) {
  MeshData mesh = square();
  mesh.cells = {0, 1, 4, 1, 2, 4, 3, 2, 4, 0, 3, 4};
  validate(mesh);
  EXPECT_THAT(std::vector(mesh.cells.begin() + 6, mesh.cells.end()), ElementsAre(3, 4, 2, 0, 4, 3));
}

TEST(Validate, TurnsLoneClockwiseCellsRound) {
  const MeshData good = square();
  for (unsigned turned = 0; turned < 16; ++turned) {
    MeshData mesh = good;
    for (std::size_t c = 0; c < 4; ++c) {
      if ((turned >> c & 1U) != 0) std::swap(mesh.cells[3 * c], mesh.cells[3 * c + 1]);
    }
    validate(mesh);
    for (int c = 0; c < 4; ++c) EXPECT_GT(Mesh(mesh).cell_measure(c), 0) << turned;
  }
}

TEST(Validate, AFoldedCellIsNotTurnedButRefused) {
  MeshData mesh = square();
  mesh.coordinates[8] = 1.2;  // the middle node, pulled over the side on the right
  expect_error(mesh, "overlaps triangle 1");
}

TEST(Validate, SpeaksInTheNumbersOfTheFile) {
  MeshData mesh = square();
  mesh.cells.insert(mesh.cells.end(), {2, 4, 1});
  mesh.cell_region.push_back(1);
  mesh.origin.cell_number = {11, 12, 13, 14, 99};
  mesh.origin.cell_place = {21, 22, 23, 24, 29};
  mesh.origin.node_number = {100, 200, 300, 400, 500};
  const MeshData text = mesh;
  EXPECT_THAT(
      [&] { validate(mesh); },
      ThrowsMessage<InputError>(
          "square:29: triangle 99 (nodes 300, 500, 200; first at (1, 1) m) is a duplicate of "
          "triangle 12 (nodes 200, 300, 500; first at (1, 0) m), in regions 'b' and 'a'; "
          "allowed: one region a cell"));
  mesh = text;
  mesh.origin.is_binary = true;
  expect_error(mesh, "square: byte 29: triangle 99");
}

TEST(Validate, Sizes) {
  MeshData mesh = square();
  mesh.cells.clear();
  mesh.cell_region.clear();
  expect_error(mesh, "the mesh has no cells");
  mesh = square();
  mesh.cell_region.pop_back();
  expect_error(mesh, "do not fit");
  mesh = square();
  mesh.cell_region[1] = 2;
  expect_error(mesh, "no region name");
}

TEST(Validate, Nodes) {
  MeshData mesh = square();
  mesh.cells[4] = 5;
  expect_error(mesh, "cell 2 has node 6; allowed: 1 to 5");
  mesh = square();
  mesh.facets[0] = -1;
  expect_error(mesh, "facet 1 has node 0; allowed: 1 to 5");
  mesh = square();
  mesh.coordinates[5] = std::numeric_limits<double>::quiet_NaN();
  expect_error(mesh, "node 3 has a coordinate that is not finite, used by triangle 2");
}

TEST(Validate, DegenerateCell) {
  MeshData mesh = square();
  mesh.coordinates[8] = 0.5;
  mesh.coordinates[9] = 0;
  expect_error(mesh, "triangle 1 (nodes 1, 2, 5; first at (0, 0) m) is degenerate");
  mesh = square();
  mesh.cells[0] = 1;
  expect_error(mesh, "triangle 1 (nodes 2, 2, 5; first at (1, 0) m) is degenerate");
}

TEST(Validate, DuplicateCell) {
  MeshData mesh = square();
  mesh.cells.insert(mesh.cells.end(), {2, 4, 1});
  mesh.cell_region.push_back(0);
  expect_error(mesh, "triangle 5 (nodes 3, 5, 2; first at (1, 1) m) is a duplicate of triangle 2");
}

TEST(Validate, OverlappingCells) {
  MeshData mesh = square();
  mesh.coordinates.insert(mesh.coordinates.end(), {0.5, 0.4});
  mesh.cells.insert(mesh.cells.end(), {0, 1, 5});
  mesh.cell_region.push_back(0);
  expect_error(mesh, "triangle 5 (nodes 1, 2, 6; first at (0, 0) m) overlaps triangle 1");
}

TEST(Validate, EdgeOfThreeCells) {
  MeshData mesh = square();
  mesh.coordinates.insert(mesh.coordinates.end(), {0.9, 0.6});
  mesh.cells.insert(mesh.cells.end(), {4, 1, 5});
  mesh.cell_region.push_back(0);
  // The third cell necessarily lies on the side of one of the others.
  expect_error(mesh, "triangle 5 (nodes 5, 2, 6; first at (0.5, 0.5) m)");
}

TEST(Validate, Facets) {
  MeshData mesh = square();
  mesh.facets = {0, 1, 1, 0};
  mesh.facet_curve = {0, 0};
  expect_error(mesh, "facet 2 of 'bottom' (nodes 2, 1) is given twice");
  mesh.facet_curve = {0, 1};  // an edge may carry two names
  EXPECT_NO_THROW(validate(mesh));
}

TEST(Validate, CurvesBesideTheCellsAreRefusedOnceUsed) {
  MeshData mesh = square();
  mesh.facets = {0, 1, 2, 0, 4, 2};
  mesh.facet_curve = {0, 1, 2};
  mesh.curve_names = {"bottom", "loose", "cut"};
  validate(mesh);
  const Mesh valid(refine(mesh, 1));
  EXPECT_EQ(valid.facets_of("bottom").size(), 2U);
  EXPECT_EQ(valid.facets_of("cut").size(), 2U);
  EXPECT_THAT([&] { (void)valid.facets_of("loose"); },
              ThrowsMessage<InputError>("square: facet 2 of 'loose' (nodes 3, 1) is no edge of a "
                                        "cell; named curves must run along cells"));
}

/// Two tetrahedra that share the face 1, 2, 3.
MeshData pair() {
  MeshData mesh;
  mesh.dim = 3;
  mesh.source = "square";
  mesh.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  mesh.cells = {0, 1, 2, 3, 1, 2, 3, 4};
  mesh.cell_region = {0, 0};
  mesh.region_names = {"a"};
  mesh.facets = {0, 2, 1};
  mesh.facet_curve = {0};
  mesh.curve_names = {"skin"};
  return mesh;
}

TEST(Validate, Tetrahedra) {
  MeshData mesh = pair();
  EXPECT_NO_THROW(validate(mesh));
  for (std::size_t c = 0; c < 2; ++c) std::swap(mesh.cells[4 * c], mesh.cells[4 * c + 1]);
  EXPECT_NO_THROW(validate(mesh));
  mesh = pair();
  std::swap(mesh.cells[0], mesh.cells[1]);
  validate(mesh);
  EXPECT_GT(Mesh(mesh).cell_measure(0), 0);
  EXPECT_NO_THROW(validate(mesh));
  mesh = pair();
  mesh.coordinates.resize(12);
  mesh.coordinates.insert(mesh.coordinates.end(), {-1, -1, -1});
  mesh.region_names = {"a", "b"};
  mesh.cell_region = {0, 1};
  expect_error(mesh, "overlaps tetrahedron 1");
  mesh = pair();
  mesh.facets = {0, 2, 4};
  validate(mesh);
  EXPECT_EQ(mesh.stray_curves.front().name, "skin");
}

}  // namespace
}  // namespace stylet
