// Meshes of tetrahedra: measures, the box, refinement, embedded points, and what is refused.
#include "stylet/base/errors.hpp"
#include "stylet/mesh/box.hpp"
#include "stylet/mesh/embedded_point.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/numbering.hpp"
#include "stylet/mesh/refine.hpp"
#include "stylet/mesh/validate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace stylet {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double round_off = 1e-13;

BoxMesh brick(int n, double jitter = 0) {
  BoxMesh p;
  p.origin = {0.1, -0.2, 0.3};
  p.width = 1;
  p.height = 2;
  p.depth = 0.5;
  p.columns = 2 * n;
  p.rows = 4 * n;
  p.layers = n;
  p.jitter = jitter;
  return p;
}

MeshData checked(MeshData data) {
  validate(data);
  return data;
}

double volume_of(const Mesh& mesh) {
  double volume = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) volume += mesh.cell_measure(c);
  return volume;
}

double worst_quality(const Mesh& mesh) {
  std::vector<int> all(static_cast<std::size_t>(mesh.n_cells()));
  std::iota(all.begin(), all.end(), 0);
  return mesh.worst_quality(all);
}

double area_of(const Mesh& mesh, const std::string& surface) {
  double area = 0;
  for (const int f : mesh.facets_of(surface)) area += mesh.facet_measure(f);
  return area;
}

TEST(Tetrahedra, QualityIsOneForTheRegularOneAndFallsToZero) {
  const Tetrahedron<ReferenceFrame> regular = {{{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}}};
  EXPECT_NEAR(std::abs(quality(regular)), 1, round_off);
  EXPECT_NEAR(std::abs(signed_volume(regular)), 8.0 / 3, round_off);
  Tetrahedron<ReferenceFrame> flat = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 1e-3}}};
  EXPECT_GT(quality(flat), 0);
  EXPECT_LT(quality(flat), 0.05);
  flat[3].z = -1e-3;
  EXPECT_LT(quality(flat), 0);
}

TEST(Tetrahedra, BoxHasItsVolumeSidesAndQuality) {
  for (const double jitter : {0.0, 0.2}) {
    const Mesh mesh(checked(make_box(brick(2, jitter))));
    EXPECT_EQ(mesh.n_cells(), 6 * 4 * 8 * 2);
    EXPECT_EQ(mesh.n_nodes(), 5 * 9 * 3);
    EXPECT_NEAR(volume_of(mesh), 1, round_off);
    EXPECT_NEAR(area_of(mesh, "left"), 1, round_off);
    EXPECT_NEAR(area_of(mesh, "top"), 0.5, round_off);
    EXPECT_NEAR(area_of(mesh, "front"), 2, round_off);
    for (const int node : mesh.nodes_of("right")) EXPECT_DOUBLE_EQ(mesh.place(node).x, 1.1);
    for (const int node : mesh.nodes_of("bottom")) EXPECT_DOUBLE_EQ(mesh.place(node).y, -0.2);
    for (const int node : mesh.nodes_of("back")) EXPECT_DOUBLE_EQ(mesh.place(node).z, 0.3);
    int inner = 0;
    for (int node = 0; node < mesh.n_nodes(); ++node) inner += mesh.on_boundary(node) ? 0 : 1;
    EXPECT_EQ(inner, 3 * 7 * 1);
    if (jitter == 0) {
      EXPECT_NEAR(worst_quality(mesh), 1.2 * std::pow(0.5, 2.0 / 3), round_off);
    }
  }
}

TEST(Tetrahedra, RegionsAreClosedAndHaveTheirVolume) {
  BoxMesh p = brick(5);
  p.inner_regions.push_back({"gland", {{0.6, 0.8, 0.55}, 0.8, 1.2, 0.4}});
  const Mesh mesh(checked(make_box(p)));
  const int gland = mesh.region_index("gland");
  double volume = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (mesh.region(c) == gland) volume += mesh.cell_measure(c);
  }
  EXPECT_NEAR(volume, std::numbers::pi / 6 * 0.8 * 1.2 * 0.4, 0.05 * volume);
  // Gauss: the flux of x/3 through a closed outward surface is the volume in it.
  double flux = 0;
  for (const int f : mesh.facets_of("gland_outline")) {
    const auto n = mesh.facet(f);
    const ReferencePlace a = mesh.place(n[0]);
    flux += dot(a - ReferencePlace{}, cross(mesh.place(n[1]) - a, mesh.place(n[2]) - a)) / 6;
  }
  EXPECT_NEAR(flux, volume, round_off);
}

TEST(Tetrahedra, BadBoxesAreRefused) {
  const auto expect = [](const BoxMesh& p, const std::string& part) {
    EXPECT_THAT([&] { make_box(p); }, ThrowsMessage<InputError>(HasSubstr(part)));
  };
  BoxMesh p = brick(1);
  p.layers = 0;
  expect(p, "box: layers = 0; allowed: 1 or more");
  p = brick(1);
  p.depth = -1;
  expect(p, "depth = -1");
  p = brick(1);
  p.columns = p.rows = p.layers = 2000;
  expect(p, "too many tetrahedra");
  p = brick(1);
  p.inner_regions.push_back({"gland", {{0.6, 0.8, 0.55}, 0.8, 1.2, 0.6}});
  expect(p, "region 'gland' reaches out of the box");
  p.inner_regions[0].ellipsoid.depth = 0.2;
  expect(p, "region 'gland' covers");
  p.columns = 100;
  expect(p, "a tetrahedron has quality");
}

TEST(Tetrahedra, RefinementIsNestedAndKeepsQuality) {
  // Of any shape: the same few shapes come back, none poorer than some share of the first.
  std::mt19937 random(3);
  const auto share = [&] { return static_cast<double>(random()) / random.max(); };
  double worst = 1;
  for (int round = 0; round < 200; ++round) {
    MeshData data;
    data.dim = 3;
    for (int i = 0; i < 12; ++i) data.coordinates.push_back(share());
    data.cells = {0, 1, 2, 3};
    data.cell_region = {0};
    data.region_names = {"tissue"};
    if (signed_volume(Tetrahedron<ReferenceFrame>{
            {{data.coordinates[0], data.coordinates[1], data.coordinates[2]},
             {data.coordinates[3], data.coordinates[4], data.coordinates[5]},
             {data.coordinates[6], data.coordinates[7], data.coordinates[8]},
             {data.coordinates[9], data.coordinates[10], data.coordinates[11]}}}) < 0) {
      std::swap(data.cells[0], data.cells[1]);
    }
    const Mesh coarse(data);
    const Mesh once(refine(data, 1));
    const Mesh fourth(refine(data, 4));
    EXPECT_NEAR(volume_of(fourth), volume_of(coarse), round_off);
    worst = std::min(worst, worst_quality(fourth) / worst_quality(once));
    EXPECT_GT(worst_quality(once) / worst_quality(coarse), 0.3) << round;
  }
  EXPECT_GT(worst, 0.99);
}

TEST(Tetrahedra, RefinedBoxIsAValidBoxOfTheSameQuality) {
  BoxMesh p = brick(1);
  const MeshData coarse = checked(make_box(p));
  MeshData fine = refine(coarse, 2);
  EXPECT_EQ(fine.n_cells(), 64 * coarse.n_cells());
  EXPECT_EQ(fine.n_facets(), 16 * coarse.n_facets());
  EXPECT_TRUE(
      std::equal(coarse.coordinates.begin(), coarse.coordinates.end(), fine.coordinates.begin()));
  validate(fine);
  EXPECT_TRUE(fine.stray_curves.empty());
  const Mesh mesh(fine);
  EXPECT_NEAR(worst_quality(mesh), worst_quality(Mesh(coarse)), round_off);
  EXPECT_NEAR(area_of(mesh, "left"), 1, round_off);
  EXPECT_EQ(mesh.n_nodes(), 9 * 17 * 5);  // the structured grid's, so no node stands twice
  EXPECT_THAT([&] { refine(coarse, 20); },
              ThrowsMessage<InputError>(HasSubstr("makes too many tetrahedra")));
}

TEST(Tetrahedra, PointsAreFoundFromAnyHint) {
  const Mesh mesh(checked(make_box(brick(2, 0.2))));
  std::mt19937 random(5);
  const auto share = [&] { return static_cast<double>(random()) / random.max(); };
  for (int i = 0; i < 200; ++i) {
    const ReferencePlace x{0.1 + share(), -0.2 + 2 * share(), 0.3 + 0.5 * share()};
    const int hint = static_cast<int>(random() % static_cast<unsigned>(mesh.n_cells()));
    const auto found = locate(mesh, x, hint);
    ASSERT_TRUE(found);
    ReferencePlace sum;
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_GE(found->weights[k], -1e-9);
      sum = sum + found->weights[k] * (mesh.place(mesh.cell(found->cell)[k]) - ReferencePlace{});
    }
    EXPECT_LT(distance(sum, x), round_off);
  }
  EXPECT_FALSE(locate(mesh, {0.1 - 1e-6, 0, 0.5}));
  EXPECT_TRUE(locate(mesh, {0.1 - 1e-10, 0, 0.5}));  // a coordinate with few digits
  EXPECT_FALSE(locate(mesh, {0.5, 0, 0.9}));
}

TEST(Tetrahedra, NumberingKeepsCellsRightHanded) {
  const MeshData data = checked(make_box(brick(2)));
  for (const int ranks : {1, 3}) {
    std::vector<int> old_cell;
    const auto numbering = number_nodes(data, ranks);
    const Mesh mesh(renumber(data, numbering, old_cell));
    EXPECT_NEAR(volume_of(mesh), 1, round_off);
    EXPECT_NEAR(area_of(mesh, "front"), 2, round_off);
  }
}

void expect_refused(MeshData data, const std::string& part) {
  EXPECT_THAT([&] { validate(data); }, ThrowsMessage<InputError>(HasSubstr(part)));
}

// Both meshes in one, which share nothing.
MeshData together(MeshData a, const MeshData& b) {
  const int n = a.n_nodes();
  a.coordinates.insert(a.coordinates.end(), b.coordinates.begin(), b.coordinates.end());
  for (const int node : b.cells) a.cells.push_back(n + node);
  a.cell_region.insert(a.cell_region.end(), b.cell_region.begin(), b.cell_region.end());
  return a;
}

TEST(Tetrahedra, MeshesThatDoNotCoverEachPointOnceAreRefused) {
  BoxMesh p = brick(1);
  const MeshData data = make_box(p);
  p.origin.x += p.width;
  expect_refused(together(data, make_box(p)), "are at the same place");
  p.origin.x += 0.3;
  expect_refused(together(data, make_box(p)), "parts that share no face");
  MeshData folded = data;
  // A node of the surface pulled through the opposite side: cells turn over.
  for (int node = 0; node < folded.n_nodes(); ++node) {
    const auto at = 3 * static_cast<std::size_t>(node);
    if (folded.coordinates[at] == 0.6 && folded.coordinates[at + 1] == 0.8) {
      folded.coordinates[at + 2] += folded.coordinates[at + 2] < 0.5 ? 0.8 : 0;
    }
  }
  expect_refused(folded, "overlap");
  MeshData flat = data;
  for (std::size_t i = 2; i < flat.coordinates.size(); i += 3) flat.coordinates[i] = 0.3;
  expect_refused(flat, "is degenerate: its volume is zero");
}

// Tetrahedra that meet without sharing faces would slide and gape.
TEST(Tetrahedra, FacesThatMeetWithoutBeingSharedAreRefused) {
  const MeshData data = make_box(brick(1));
  MeshData hanging =
      data;  // one tetrahedron cut at the middle of an edge, its neighbours as they were
  const int middle = data.n_nodes();
  for (std::size_t k = 0; k < 3; ++k) {
    const auto of = [&](std::size_t corner) {
      return data.coordinates[3 * static_cast<std::size_t>(data.cells[corner]) + k];
    };
    hanging.coordinates.push_back(0.5 * (of(0) + of(3)));
  }
  hanging.cells[3] = middle;
  hanging.cells.insert(hanging.cells.end(), {middle, data.cells[1], data.cells[2], data.cells[3]});
  hanging.cell_region.push_back(0);
  expect_refused(hanging, "whose tetrahedron does not have it");
  // A pyramid on a square that a pyramid below cuts along the other diagonal.
  MeshData crossed;
  crossed.dim = 3;
  crossed.source = "crossed";
  crossed.coordinates = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 1, 0.5, 0.5, -1, -1, 0, 0};
  crossed.cells = {0, 1, 2, 4, 0, 2, 3, 4, 0, 1, 3, 5, 1, 2, 3, 5, 0, 3, 4, 6, 0, 3, 5, 6};
  crossed.cell_region.assign(6, 0);
  crossed.region_names = {"tissue"};
  expect_refused(crossed, "lies on the outer triangle");
}

// A bar bent into a ring that goes round more than once.
TEST(Tetrahedra, ABarThatRunsThroughItselfIsRefused) {
  BoxMesh p;
  p.width = 40;
  p.height = p.depth = 1;
  p.columns = 80;
  p.rows = p.layers = 2;
  const auto bent = [&](double turns, double rise) {
    MeshData data = make_box(p);
    for (std::size_t i = 0; i < data.coordinates.size(); i += 3) {
      const double angle = 2 * std::numbers::pi * turns * data.coordinates[i] / 40;
      const double radius = 5 + data.coordinates[i + 1];
      const double z = data.coordinates[i + 2] + rise * data.coordinates[i];
      data.coordinates[i] = radius * std::cos(angle);
      data.coordinates[i + 1] = radius * std::sin(angle);
      data.coordinates[i + 2] = z;
    }
    return data;
  };
  MeshData spiral = bent(1.2, 0.05);
  EXPECT_NO_THROW(validate(spiral));
  expect_refused(bent(1.2, 0.01), "tetrahedra overlap: the outer edge");
}

}  // namespace
}  // namespace stylet
