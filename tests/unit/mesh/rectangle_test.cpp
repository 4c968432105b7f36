#include "stylet/mesh/rectangle.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/validate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace stylet {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

RectangleMesh plain() {
  RectangleMesh p;
  p.origin = {0.01, -0.02};
  p.width = 0.08;
  p.height = 0.06;
  p.columns = 32;
  p.rows = 24;
  return p;
}

const Ellipse gland{{0.045, 0.01}, 0.035, 0.026};

RectangleMesh with_gland() {
  RectangleMesh p = plain();
  p.inner_regions = {{"prostate", gland}};
  return p;
}

double worst_quality(const Mesh& mesh) {
  std::vector<int> all(mesh.n_cells());
  std::iota(all.begin(), all.end(), 0);
  return mesh.worst_quality(all);
}

double area_of(const Mesh& mesh, const std::string& region) {
  double area = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (mesh.region(c) == mesh.region_index(region)) area += mesh.cell_measure(c);
  }
  return area;
}

double length_of(const Mesh& mesh, const std::string& curve) {
  double length = 0;
  for (int f : mesh.facets_of(curve)) {
    length +=
        distance(mesh.point(mesh.data().facets[2 * f]), mesh.point(mesh.data().facets[2 * f + 1]));
  }
  return length;
}

Mesh checked(const RectangleMesh& p) {
  MeshData data = make_rectangle(p);
  const std::vector<int> cells = data.cells;
  validate(data);
  EXPECT_EQ(data.cells, cells);  // counter-clockwise from the start
  return Mesh(std::move(data));
}

void expect_error(const RectangleMesh& p, const std::string& part) {
  EXPECT_THAT([&p] { make_rectangle(p); }, ThrowsMessage<InputError>(HasSubstr(part)));
}

TEST(Rectangle, CountsAreaAndSides) {
  for (const Diagonals diagonals : {Diagonals::one_way, Diagonals::alternating}) {
    RectangleMesh p = plain();
    p.diagonals = diagonals;
    const Mesh mesh = checked(p);
    EXPECT_EQ(mesh.n_nodes(), 33 * 25);
    EXPECT_EQ(mesh.n_cells(), 2 * 32 * 24);
    EXPECT_NEAR(area_of(mesh, "tissue"), 0.08 * 0.06, 1e-16);  // rounding
    EXPECT_THAT(mesh.data().curve_names, ElementsAre("left", "right", "bottom", "top"));
    EXPECT_NEAR(length_of(mesh, "left"), 0.06, 1e-15);
    EXPECT_NEAR(length_of(mesh, "top"), 0.08, 1e-15);
    for (int i : mesh.nodes_of("left")) EXPECT_EQ(mesh.point(i).x, 0.01);
    for (int i : mesh.nodes_of("bottom")) EXPECT_EQ(mesh.point(i).y, -0.02);
    EXPECT_EQ(mesh.nodes_of("right").size(), 25U);
    // Legs of equal length: 4 sqrt(3) (1/2) / (1 + 1 + 2).
    EXPECT_NEAR(worst_quality(mesh), std::sqrt(3.0) / 2, 1e-12);
  }
}

TEST(Rectangle, DiagonalsAlternate) {
  RectangleMesh p = plain();
  p.columns = 2;
  p.rows = 1;
  EXPECT_THAT(make_rectangle(p).cells, ElementsAre(0, 1, 4, 0, 4, 3, 1, 2, 4, 2, 5, 4));
  p.diagonals = Diagonals::one_way;
  EXPECT_THAT(make_rectangle(p).cells, ElementsAre(0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4));
}

TEST(Rectangle, JitterMovesInnerNodesOnly) {
  RectangleMesh p = plain();
  const Mesh regular = checked(p);
  p.jitter = 0.29;
  p.curves = {{"path", {{0.09, 0.01}, {0.05, 0.01}}}};
  const Mesh mesh = checked(p);
  const auto path = mesh.nodes_of("path");
  const double spacing = 0.08 / 32;
  int n_moved = 0;
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    const Vector2 shift = mesh.point(i) - regular.point(i);
    if (mesh.on_boundary(i) || std::ranges::binary_search(path, i)) {
      EXPECT_EQ(norm(shift), 0);
    } else {
      EXPECT_LE(std::max(std::abs(shift.x), std::abs(shift.y)), 0.29 * spacing);
      n_moved += norm(shift) > 0 ? 1 : 0;
    }
  }
  EXPECT_EQ(n_moved, 31 * 23 - 16);  // the path has 17 nodes, one of them on the side
  EXPECT_GT(worst_quality(mesh), 0.1);
  EXPECT_EQ(make_rectangle(p).coordinates, mesh.data().coordinates);
  p.seed = 2;
  EXPECT_NE(make_rectangle(p).coordinates, mesh.data().coordinates);
}

TEST(Rectangle, JitterIsTheSameOnEveryMachine) {
  RectangleMesh p;
  p.width = 2;
  p.height = 2;
  p.columns = 2;
  p.rows = 2;
  p.jitter = 0.25;
  p.seed = 5489;
  std::mt19937 random(5489);
  for (int i = 0; i < 8; ++i) random();
  const double dx = 0.25 * (2 * (static_cast<double>(random()) * 0x1p-32) - 1);
  EXPECT_EQ(make_rectangle(p).coordinates[8], 1 + dx);  // node 4 takes the ninth number
}

TEST(Rectangle, EllipseIsMet) {
  for (const Diagonals diagonals : {Diagonals::one_way, Diagonals::alternating}) {
    for (const double jitter : {0.0, 0.2}) {
      RectangleMesh p = with_gland();
      p.diagonals = diagonals;
      p.jitter = jitter;
      const Mesh mesh = checked(p);
      EXPECT_EQ(mesh.n_nodes(), 33 * 25);
      EXPECT_EQ(mesh.n_cells(), 2 * 32 * 24);
      EXPECT_GT(worst_quality(mesh), jitter > 0 ? 0.25 : 0.45);  // what smoothing reaches
      const double area = std::acos(-1.0) / 4 * 0.035 * 0.026;
      EXPECT_NEAR(area_of(mesh, "prostate"), area, 0.03 * area);
      EXPECT_NEAR(area_of(mesh, "prostate") + area_of(mesh, "tissue"), 0.0048, 1e-16);
      const auto outline = mesh.nodes_of("prostate_outline");
      EXPECT_EQ(outline.size(), mesh.facets_of("prostate_outline").size());  // one closed loop
      for (int i : outline) {
        const double x = 2 * (mesh.point(i).x - 0.045) / 0.035;
        const double y = 2 * (mesh.point(i).y - 0.01) / 0.026;
        EXPECT_NEAR(x * x + y * y, 1, 1e-12);  // on the ellipse to rounding
      }
    }
  }
}

TEST(Rectangle, EllipseIsMetOnManyGrids) {
  for (const Diagonals diagonals : {Diagonals::one_way, Diagonals::alternating}) {
    for (int columns = 24; columns < 60; ++columns) {
      RectangleMesh p = with_gland();
      p.diagonals = diagonals;
      p.columns = columns;
      p.rows = columns * 3 / 4 + columns % 3;
      EXPECT_GT(worst_quality(checked(p)), 0.4) << columns;
    }
  }
}

TEST(Rectangle, PolygonIsMetExactly) {
  RectangleMesh p = plain();
  const std::vector<ReferencePoint> corners = {
      {0.03, -0.007}, {0.071, 0.0}, {0.065, 0.027}, {0.045, 0.012}, {0.028, 0.02}};
  p.inner_regions = {{"core", corners}};
  const Mesh mesh = checked(p);
  double area = 0;
  double length = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto a = corners[i];
    const auto b = corners[(i + 1) % corners.size()];
    area += 0.5 * (a.x * b.y - a.y * b.x);
    length += distance(a, b);
  }
  EXPECT_NEAR(area_of(mesh, "core"), area, 1e-9 * area);
  EXPECT_NEAR(length_of(mesh, "core_outline"), length, 1e-9 * length);
  EXPECT_GT(worst_quality(mesh), 0.3);
}

TEST(Rectangle, RegionsInEachOtherAndAtTheSide) {
  RectangleMesh p = with_gland();
  p.inner_regions.push_back({"tumour", Ellipse{{0.048, 0.008}, 0.016, 0.014}});
  // A layer under the right side, off the grid lines: side nodes slide along the side.
  p.inner_regions.push_back(
      {"skin",
       std::vector<ReferencePoint>{{0.0819, -0.02}, {0.09, -0.02}, {0.09, 0.04}, {0.0821, 0.04}}});
  const Mesh mesh = checked(p);
  EXPECT_THAT(mesh.data().region_names, ElementsAre("tissue", "prostate", "tumour", "skin"));
  const double pi = std::acos(-1.0);
  const double tumour = pi / 4 * 0.016 * 0.014;
  EXPECT_NEAR(area_of(mesh, "tumour"), tumour, 0.03 * tumour);
  EXPECT_NEAR(area_of(mesh, "prostate"), pi / 4 * 0.035 * 0.026 - tumour, 0.03 * tumour + 2e-5);
  EXPECT_NEAR(area_of(mesh, "skin"), 0.06 * 0.008, 1e-12);
  EXPECT_NEAR(length_of(mesh, "right"), 0.06, 1e-15);
}

TEST(Rectangle, CurveThroughAnOutline) {
  RectangleMesh p = with_gland();
  p.jitter = 0.1;
  p.curves = {{"path", {{0.09, 0.01}, {0.04, 0.01}}}, {"patch", {{0.09, 0.0}, {0.09, 0.02}}}};
  const Mesh mesh = checked(p);
  EXPECT_NEAR(length_of(mesh, "path"), 0.05, 1e-14);
  EXPECT_NEAR(length_of(mesh, "patch"), 0.02, 1e-14);
  for (int i : mesh.nodes_of("path")) EXPECT_NEAR(mesh.point(i).y, 0.01, 1e-15);
}

TEST(Rectangle, CurveThatTurnsTakesNoShortCut) {
  RectangleMesh p;
  p.width = 4;
  p.height = 4;
  p.columns = 4;
  p.rows = 4;
  p.curves = {{"bend", {{1, 3}, {1, 1}, {3, 1}}}};
  for (const Diagonals diagonals : {Diagonals::one_way, Diagonals::alternating}) {
    p.diagonals = diagonals;
    const Mesh mesh = checked(p);
    EXPECT_EQ(mesh.facets_of("bend").size(), 4U);
    EXPECT_DOUBLE_EQ(length_of(mesh, "bend"), 4);
  }
}

TEST(Rectangle, ParameterErrors) {
  const auto with = [](auto change, const std::string& part) {
    RectangleMesh p = plain();
    change(p);
    expect_error(p, "rectangle: " + part);
  };
  with([](auto& p) { p.width = 0; }, "width = 0; allowed: above 0 m");
  with([](auto& p) { p.height = NAN; }, "height = nan; allowed: above 0 m");
  with([](auto& p) { p.columns = 0; }, "columns = 0; allowed: 1 or more");
  with([](auto& p) { p.rows = -3; }, "rows = -3; allowed: 1 or more");
  with([](auto& p) { p.rows = p.columns = 100000; },
       "100000 columns and 100000 rows make too many");
  with([](auto& p) { p.jitter = 0.3; }, "jitter = 0.3; allowed: 0 or more, below 0.3");
  with([](auto& p) { p.region = ""; }, "a region or a curve has no name");
  with([](auto& p) { p.inner_regions = {{"tissue", gland}}; }, "the name 'tissue' is given twice");
  with(
      [](auto& p) {
        p.curves = {{"top", {{0.01, 0.01}, {0.09, 0.01}}}};
      },
      "the name 'top' is given twice");
  with([](auto& p) { p.curves = {{"path", {{0.01, 0.01}}}}; }, "curve 'path' needs two points");
  with(
      [](auto& p) {
        p.inner_regions = {{"g", Ellipse{{0.045, 0.03}, 0.035, 0.026}}};
      },
      "region 'g' reaches out of the rectangle");
  with(
      [](auto& p) {
        p.inner_regions = {{"g", Ellipse{{0.045, 0.01}, 0.035, 0}}};
      },
      "region 'g': ellipse of 0.035 x 0 m");
}

TEST(Rectangle, CurveOffTheGrid) {
  RectangleMesh p = plain();
  p.curves = {{"path", {{0.09, 0.0113}, {0.05, 0.0113}}}};
  expect_error(p, "curve 'path': triangle edges cover 0 m of its 0.04 m");
  p.curves = {{"path", {{0.10, 0.01}, {0.05, 0.01}}}};
  expect_error(p, "it must run along grid lines");
}

TEST(Rectangle, TooCoarse) {
  RectangleMesh p = with_gland();
  p.columns = 4;
  p.rows = 3;
  expect_error(p, "the grid is too coarse: raise columns (now 4) and rows (now 3)");
  p = plain();
  p.columns = 1;
  p.rows = 40;
  expect_error(p, "quality 0.03");
  expect_error(p, "the grid is too coarse: raise columns (now 1)");
}

}  // namespace
}  // namespace stylet
