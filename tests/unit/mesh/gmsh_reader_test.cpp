#include "stylet/mesh/gmsh_reader.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/validate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace stylet {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

// Two surfaces that share the diagonal of the unit square, and a node that no element uses.
const std::string square_22 = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
1 3 "bottom"
1 4 "the cut"
2 1 "low"
2 2 "high"
$EndPhysicalNames
$Nodes
6
1 0 0 0
2 1 0 0
9 7 7 0
3 1 1 0
4 0 1 0
5 0.5 0.5 0
$EndNodes
$Elements
8
8 15 2 0 1 1
1 1 2 3 1 1 2
2 1 2 4 5 1 5
3 1 2 4 5 5 3
4 2 2 1 1 2 5 1
5 2 2 1 1 2 3 5
6 2 2 2 2 1 5 4
7 2 2 2 2 5 3 4
$EndElements
)";

const std::string square_41 = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
4
1 3 "bottom"
1 4 "the cut"
2 1 "low"
2 2 "high"
$EndPhysicalNames
$Entities
1 2 2 0
1 0 0 0 0
1 0 0 0 1 0 0 1 3 2 1 -2
5 0 0 0 1 1 0 1 -4 2 1 -3
1 0 0 0 1 1 0 1 1 3 1 2 -5
2 0 0 0 1 1 0 1 2 3 5 3 4
$EndEntities
$Nodes
4 6 1 9
0 1 0 3
1
2
9
0 0 0
1 0 0
7 7 0
0 3 0 1
3
1 1 0
2 1 0 0
1 5 1 2
4
5
0 1 0 0.25
0.5 0.5 0 0.5
$EndNodes
$Elements
5 8 1 8
0 1 15 1
8 1
1 1 1 1
1 1 2
1 5 1 2
2 1 5
3 5 3
2 1 2 2
4 2 5 1
5 2 3 5
2 2 2 2
6 1 5 4
7 5 3 4
$EndElements
$NodeData
anything
$EndNodeData
)";

const std::string tetrahedra = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 5 "skin"
3 1 "tissue"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 1 1 1
$EndNodes
$Elements
5
1 1 2 0 1 1 2
2 2 2 0 1 1 2 4
3 2 2 5 1 1 3 2
4 4 2 1 1 1 2 3 4
5 4 2 1 1 2 3 4 5
$EndElements
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

auto says(const std::string& part) {
  return ThrowsMessage<InputError>(HasSubstr(part));
}

void expect_equal(const MeshData& a, const MeshData& b) {
  EXPECT_EQ(a.dim, b.dim);
  EXPECT_EQ(a.coordinates, b.coordinates);
  EXPECT_EQ(a.cells, b.cells);
  EXPECT_EQ(a.cell_region, b.cell_region);
  EXPECT_EQ(a.region_names, b.region_names);
  EXPECT_EQ(a.facets, b.facets);
  EXPECT_EQ(a.facet_curve, b.facet_curve);
  EXPECT_EQ(a.curve_names, b.curve_names);
}

TEST(GmshReader, ReadsCellsFacetsAndNames) {
  const MeshData mesh = read_gmsh("square.msh", square_22);
  EXPECT_EQ(mesh.dim, 2);
  EXPECT_EQ(mesh.source, "square.msh");
  EXPECT_THAT(mesh.coordinates, ElementsAre(0, 0, 1, 0, 1, 1, 0, 1, 0.5, 0.5));
  EXPECT_THAT(mesh.cells, ElementsAre(1, 4, 0, 1, 2, 4, 0, 4, 3, 4, 2, 3));
  EXPECT_THAT(mesh.cell_region, ElementsAre(0, 0, 1, 1));
  EXPECT_THAT(mesh.region_names, ElementsAre("low", "high"));
  EXPECT_THAT(mesh.facets, ElementsAre(0, 1, 0, 4, 4, 2));
  EXPECT_THAT(mesh.facet_curve, ElementsAre(0, 1, 1));
  EXPECT_THAT(mesh.curve_names, ElementsAre("bottom", "the cut"));
}

TEST(GmshReader, BothFormatsGiveTheSameMesh) {
  expect_equal(read_gmsh("a", square_22), read_gmsh("a", square_41));
}

TEST(GmshReader, LineEndsOfWindowsAreFine) {
  std::string text;
  for (char c : square_41) text += c == '\n' ? "\r\n" : std::string(1, c);
  expect_equal(read_gmsh("a", text), read_gmsh("a", square_41));
}

TEST(GmshReader, CommentsMayComeFirst) {
  expect_equal(read_gmsh("a", "$Comments\nany $words\n$EndComments\n" + square_22),
               read_gmsh("a", square_22));
}

TEST(GmshReader, ScaleMultipliesCoordinates) {
  const MeshData mesh = read_gmsh("a", square_22, 0.001);
  EXPECT_DOUBLE_EQ(mesh.coordinates[2], 0.001);
  EXPECT_THAT([] { read_gmsh("a", square_22, 0); }, says("a: scale = 0"));
}

TEST(GmshReader, TetrahedraMakeTrianglesFacets) {
  MeshData mesh = read_gmsh("a", tetrahedra);
  EXPECT_EQ(mesh.dim, 3);
  EXPECT_EQ(mesh.n_cells(), 2);
  EXPECT_THAT(mesh.facets, ElementsAre(0, 2, 1));
  EXPECT_THAT(mesh.curve_names, ElementsAre("skin"));
  EXPECT_THAT(mesh.region_names, ElementsAre("tissue"));
}

TEST(GmshReader, ProstateOfTheMeshFolder) {
  std::ifstream file(std::string(STYLET_SOURCE_DIR) + "/meshes/prostate.msh");
  std::ostringstream text;
  text << file.rdbuf();
  MeshData data = read_gmsh("prostate.msh", text.str());
  validate(data);
  EXPECT_GE(data.n_cells(), 1150);
  EXPECT_LE(data.n_cells(), 1350);
  EXPECT_THAT(data.region_names, ElementsAre("prostate", "surrounding"));
  EXPECT_THAT(data.curve_names, ElementsAre("bottom", "right", "top", "left", "prostate_outline"));
  const Mesh mesh(std::move(data));
  double area = 0;
  double worst = 1;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    area += mesh.cell_measure(c);
    worst = std::min(worst, mesh.cell_quality(c));
  }
  EXPECT_NEAR(area, 0.08 * 0.06, 1e-12);  // rounding of 1300 additions
  EXPECT_GT(worst, 0.5);                  // what a Delaunay mesh of one size gives
}

TEST(GmshReader, NoMesh) {
  EXPECT_THAT([] { read_gmsh("m", ""); }, says("m:1: the file is empty"));
  EXPECT_THAT([] { read_gmsh("m", " \n\n"); }, says("the file is empty"));
  EXPECT_THAT([] { read_gmsh("m", "solid cube\n"); }, says("found 'solid'; is this a Gmsh file?"));
  EXPECT_THAT([] { read_gmsh("m", "$Nodes\n0\n$EndNodes\n"); }, says("expected $MeshFormat"));
}

TEST(GmshReader, VersionsOfFormat2) {
  for (const char* version : {"2", "2.0", "2.1", "2.200000", "2.2000000000000002"}) {
    expect_equal(read_gmsh("a", replaced(square_22, "2.2 0", std::string(version) + " 0")),
                 read_gmsh("a", square_22));
  }
  // Format 2.0 names groups without their dimension.
  std::string bare = replaced(square_22, "1 4 \"the cut\"\n2 1", "4 \"the cut\"\n1");
  expect_equal(read_gmsh("a", bare), read_gmsh("a", square_22));
}

TEST(GmshReader, AMarkOfByteOrderIsNoWord) {
  expect_equal(read_gmsh("a", "\uFEFF" + square_22), read_gmsh("a", square_22));
  EXPECT_THAT([] { read_gmsh("m", "\xFF\xFE$"); },
              says("m:1: expected a section such as $MeshFormat, "
                   "found '<0xFF><0xFE>$'"));
}

TEST(GmshReader, PlusSignsAreFine) {
  expect_equal(read_gmsh("a", replaced(square_22, "0.5 0.5 0", "+5.0E-01 +.5 +0")),
               read_gmsh("a", square_22));
}

TEST(GmshReader, WrongFormat) {
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "2.2 0", "3 0")); },
              says("m:2: Gmsh format 3; allowed: 2 and 4.1, ASCII or binary"));
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "2.2 0", "4.0 1")); },
              says("m:2: binary file of Gmsh format 4.0"));
  EXPECT_THAT([] { read_gmsh("m", "$NOD\n3\n1 0 0 0\n"); }, says("m:1: Gmsh format 1 ($NOD)"));
  EXPECT_THAT([] { read_gmsh("m", replaced(square_41, "$Entities", "$PartitionedEntities")); },
              says("m:11: partitioned mesh"));
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "7 2 2 2 2", "7 2 4 2 2 1 1")); },
              says("m:29: partitioned mesh"));
  // Old files have a partition of 0 where there is none.
  expect_equal(read_gmsh("a", replaced(square_22, "7 2 2 2 2", "7 2 3 2 2 0")),
               read_gmsh("a", square_22));
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "$Nodes", "$ParametricNodes")); },
              says("m:11: parametric nodes"));
}

TEST(GmshReader, EveryTruncationIsAnError) {
  for (const auto& text : {square_22, square_41}) {
    const std::size_t last = text.find("$EndElements") + std::string("$EndElements").size();
    for (std::size_t n = 0; n < last; ++n) {
      EXPECT_THROW(read_gmsh("m", text.substr(0, n)), InputError) << n;
    }
  }
  EXPECT_THAT([] { read_gmsh("m", square_22.substr(0, square_22.find("$Elements"))); },
              says("the file ends without $Elements: truncated?"));
}

TEST(GmshReader, BadNumbers) {
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "0.5 0.5", "0.5 half")); },
              says("m:18: expected a coordinate, found 'half'"));
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "$Nodes\n6", "$Nodes\n5")); },
              says("m:18: expected $EndNodes, found '5'; does the count"));
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "$Nodes\n6", "$Nodes\n-6")); },
              says("m:12: the number of nodes is negative: -6"));
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "9 7 7 0", "1 7 7 0")); },
              says("node 1 is given twice"));
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "2 2 5 3 4", "2 2 5 3 44")); },
              says("m:29: triangle 7 uses node 44, which is not in $Nodes"));
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "\"low\"", "low")); },
              says("m:8: expected a name in double quotes"));
}

TEST(GmshReader, ElementTypes) {
  const auto with_type = [](const std::string& type) {
    return [type] { read_gmsh("m", replaced(square_22, "4 2 2 1", "4 " + type + " 2 1")); };
  };
  EXPECT_THAT(with_type("9"),
              says("m:26: a second-order triangle (element type 9); allowed: points"));
  EXPECT_THAT(with_type("9"), says("Use gmsh -order 1"));
  EXPECT_THAT(with_type("3"), says("a quadrangle (element type 3); allowed"));
  EXPECT_THAT(with_type("77"), says("an element (element type 77); allowed"));
}

TEST(GmshReader, RegionsNeedNames) {
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "6 2 2 2 2", "6 2 2 0 2")); },
              says("m:28: unnamed region: triangle 6 of surface 2 has no physical surface"));
  EXPECT_THAT(
      [] { read_gmsh("m", replaced(square_41, "2 0 0 0 1 1 0 1 2 3", "2 0 0 0 1 1 0 0 3")); },
      says("unnamed region: triangle 6 of surface 2"));
  EXPECT_THAT(
      [] { read_gmsh("m", replaced(square_41, "2 0 0 0 1 1 0 1 2 3", "2 0 0 0 1 1 0 2 2 1 3")); },
      says("triangle 6 of surface 2 has two physical groups, 'high' and 'low'; allowed: one"));
  EXPECT_THAT(
      [] { read_gmsh("m", replaced(square_22, "4 2 2 1 1", "4 2 0")); },
      ThrowsMessage<InputError>("m:26: unnamed region: triangle 4 has no physical surface"));
}

TEST(GmshReader, GroupsWithoutNamesAreCalledByNumber) {
  MeshData mesh = read_gmsh("m", replaced(square_22, "2 2 \"high\"", "2 8 \"high\""));
  EXPECT_THAT(mesh.region_names, ElementsAre("low", "2"));
  mesh = read_gmsh("m", replaced(square_22, "1 3 \"bottom\"", "1 3 \"\""));
  EXPECT_THAT(mesh.curve_names, ElementsAre("the cut", "3"));
  EXPECT_THAT(mesh.facet_curve, ElementsAre(1, 0, 0));
  EXPECT_THAT(
      [] {
        read_gmsh(
            "m", replaced(replaced(square_22, "2 2 \"high\"", "2 8 \"high\""), "\"low\"", "\"2\""));
      },
      says("physical surface 2 has no name, and another one is named '2'"));
}

TEST(GmshReader, OneNameMayStandForSeveralGroups) {
  const MeshData mesh = read_gmsh("m", replaced(square_22, "\"high\"", "\"low\""));
  EXPECT_THAT(mesh.region_names, ElementsAre("low"));
  // Also for two groups of one curve.
  const MeshData both = read_gmsh("m", replaced(replaced(square_41, "\"the cut\"", "\"bottom\""),
                                                "0 1 -4 2 1", "0 2 -4 3 2 1"));
  EXPECT_THAT(both.curve_names, ElementsAre("bottom"));
  EXPECT_EQ(both.n_facets(), 3);
}

TEST(GmshReader, ManyGroupsOfOneCurveAreRefused) {
  // 1000 groups times 1000 lines would be stored a million times.
  std::string groups = "1000";
  for (int i = 1; i <= 1000; ++i) groups += " " + std::to_string(i);
  EXPECT_THAT([&] { read_gmsh("m", replaced(square_41, "0 1 -4 2 1", "0 " + groups + " 2 1")); },
              says("line 2 of curve 5 is in 1000 physical groups; allowed: 64"));
}

TEST(GmshReader, GeometryErrors) {
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "5 0.5 0.5 0", "5 0.5 0.5 0.1")); },
              says("m:18: z = 0.1"));
  EXPECT_NO_THROW(read_gmsh("m", replaced(square_22, "9 7 7 0", "9 7 7 3")));  // not used
  EXPECT_THAT([] { read_gmsh("m", replaced(square_22, "5 0.5 0.5 0", "5 0.5 nan 0")); },
              says("m:18: expected a coordinate, found a number not finite"));
  const Mesh stray(read_gmsh("m", replaced(square_22, "2 3 1 1 2", "2 3 1 1 9")));
  EXPECT_EQ(stray.facets_of("the cut").size(), 2U);
  EXPECT_THAT([&] { (void)stray.facets_of("bottom"); },
              says("m:23: line 1 of 'bottom' has a node that is on no cell"));
  EXPECT_THAT([] { read_gmsh("m", tetrahedra, 1, 2); },
              says("m:22: tetrahedron 4 of volume 1; allowed: a plane mesh"));
  EXPECT_THAT(
      [] {
        read_gmsh(
            "m", square_22.substr(0, square_22.find("$Elements")) + "$Elements\n0\n$EndElements\n");
      },
      says("no triangles or tetrahedra"));
}

}  // namespace
}  // namespace stylet
