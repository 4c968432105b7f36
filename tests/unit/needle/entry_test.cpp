#include "stylet/base/errors.hpp"
#include "stylet/needle/advance.hpp"

#include "bench.hpp"
#include <gtest/gtest.h>

namespace stylet {

namespace {

Entry entry_at(const Mesh& mesh, double height) {
  return find_entry(mesh, {height}, "needle");
}

TEST(Entry, AtANode) {
  const Mesh mesh(tissue(8, 6));
  const Entry entry = entry_at(mesh, 0.03);
  EXPECT_EQ(mesh.point(entry.node), (ReferencePoint{0.08, 0.03}));
  EXPECT_EQ(entry.fraction, 0);
  EXPECT_EQ(entry.x, (ReferencePoint{0.08, 0.03}));
}

TEST(Entry, NearerNodeSlides) {
  const Mesh mesh(tissue(8, 6));
  const Entry low = entry_at(mesh, 0.033);
  EXPECT_EQ(mesh.point(low.node), (ReferencePoint{0.08, 0.03}));
  EXPECT_EQ(mesh.point(low.neighbour), (ReferencePoint{0.08, 0.04}));
  EXPECT_NEAR(low.fraction, 0.3, 1e-14);  // one division of numbers with 14 digits left
  const Entry high = entry_at(mesh, 0.038);
  EXPECT_EQ(mesh.point(high.node), (ReferencePoint{0.08, 0.04}));
  EXPECT_NEAR(high.fraction, 0.2, 1e-14);
  EXPECT_EQ(high.x.y, 0.038);
}

TEST(Entry, CornersStayWhereTheyAre) {
  const Mesh mesh(tissue(8, 6));
  const Entry entry = entry_at(mesh, 0.002);
  EXPECT_EQ(mesh.point(entry.node), (ReferencePoint{0.08, 0.01}));
  EXPECT_NEAR(entry.fraction, 0.8, 1e-14);
}

TEST(Entry, BetweenTwoCornersIsRefused) {
  const Mesh mesh(tissue(4, 1));
  EXPECT_THROW((void)entry_at(mesh, 0.02), InputError);
}

TEST(Entry, MissesTheTissue) {
  const Mesh mesh(tissue(8, 6));
  EXPECT_THROW((void)entry_at(mesh, 0.07), InputError);
  EXPECT_THROW((void)entry_at(mesh, -1e-9), InputError);
}

TEST(Entry, FirstSkinFromOutside) {
  // A cavity on the axis has two more boundary edges; the needle enters at the outermost.
  MeshData data = tissue(8, 6);
  MeshData open = data;
  open.cells.clear();
  open.cell_region.clear();
  for (int c = 0; c < data.n_cells(); ++c) {
    double x = 0;
    double y = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto node = static_cast<std::size_t>(data.cells[3 * static_cast<std::size_t>(c) + i]);
      x += data.coordinates[2 * node] / 3;
      y += data.coordinates[2 * node + 1] / 3;
    }
    if (x > 0.03 && x < 0.05 && y > 0.02 && y < 0.04) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      open.cells.push_back(data.cells[3 * static_cast<std::size_t>(c) + i]);
    }
    open.cell_region.push_back(0);
  }
  const Mesh mesh(open);
  EXPECT_EQ(entry_at(mesh, 0.033).x.x, 0.08);
}

TEST(Entry, EveryHeightAndNumbering) {
  const MeshData data = tissue(8, 6, 0.2);
  const Mesh plain(data);
  for (unsigned seed = 1; seed < 4; ++seed) {
    const Mesh other = permuted(data, seed);
    for (double height = 0.0013; height < 0.0588; height += 0.00071) {
      const Entry a = entry_at(plain, height);
      const Entry b = entry_at(other, height);
      EXPECT_EQ(plain.point(a.node), other.point(b.node));
      EXPECT_EQ(a.fraction, b.fraction);
      EXPECT_EQ(a.x, b.x);
      EXPECT_EQ(a.x.y, height);
    }
  }
}

}  // namespace

}  // namespace stylet
