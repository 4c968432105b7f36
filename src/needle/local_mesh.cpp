#include "stylet/needle/local_mesh.hpp"

#include "stylet/base/sorted.hpp"
#include "stylet/geometry/triangle.hpp"
#include "stylet/needle/axis.hpp"

#include <algorithm>
#include <set>

namespace stylet {

namespace {

std::vector<int> nodes_of(const Mesh& mesh, std::span<const int> cells) {
  std::vector<int> nodes;
  for (const int c : cells) {
    for (const int node : mesh.cell(c)) nodes.push_back(node);
  }
  sort_unique(nodes);
  return nodes;
}

std::vector<int> cells_around(const Mesh& mesh, std::span<const int> nodes) {
  std::vector<int> cells;
  for (const int node : nodes) {
    for (const int c : mesh.cells_around(node)) cells.push_back(c);
  }
  sort_unique(cells);
  return cells;
}

// The cells around the nodes and their neighbours, in the numbers of `used`.
MeshData copy_of(const Mesh& mesh, std::span<const int> cells, std::span<const int> used) {
  MeshData data;
  data.source = mesh.data().source;
  data.region_names = mesh.data().region_names;
  data.curve_names = {"locked"};
  const auto number = [&](int node) {
    return static_cast<int>(std::ranges::lower_bound(used, node) - used.begin());
  };
  for (const int node : used) {
    const auto x = mesh.coordinates(node);
    data.coordinates.insert(data.coordinates.end(), x.begin(), x.end());
  }
  for (const int c : cells) {
    const auto n = mesh.cell(c);
    for (std::size_t i = 0; i < 3; ++i) {
      data.cells.push_back(number(n[i]));
      const int a = n[i];
      const int b = n[(i + 1) % 3];
      if (!mesh.is_locked_edge(a, b)) continue;
      data.facets.insert(data.facets.end(), {number(a), number(b)});
      data.facet_curve.push_back(0);
    }
    data.cell_region.push_back(mesh.region(c));
  }
  return data;
}

}  // namespace

LocalMesh::LocalMesh(const Mesh& mesh, std::span<const int> nodes)
    : nodes_([&] {
        const auto ring = nodes_of(mesh, cells_around(mesh, nodes));
        return nodes_of(mesh, cells_around(mesh, ring));
      }()),
      mesh_([&] {
        const auto ring = nodes_of(mesh, cells_around(mesh, nodes));
        return copy_of(mesh, cells_around(mesh, ring), nodes_);
      }()) {
  mesh_.lock_curve("locked");
}

int LocalMesh::local(int node) const {
  const auto found = std::ranges::lower_bound(nodes_, node);
  return found != nodes_.end() && *found == node ? static_cast<int>(found - nodes_.begin()) : -1;
}

Track LocalMesh::local(const Track& track) const {
  Track result;
  for (ShaftNode shaft : track.nodes()) {
    shaft.node = local(shaft.node);
    result.push(shaft);
  }
  return result;
}

std::optional<EdgeFlip> best_flip(const Mesh& mesh,
                                  const Track& track,
                                  std::span<const int> touched_cells,
                                  double wanted) {
  const std::set<int> cells(touched_cells.begin(), touched_cells.end());
  std::optional<EdgeFlip> best;
  ReferencePoint best_middle;
  constexpr double worth_it = 1.05;  // a flip must raise the worst quality by this factor
  double best_gain = 0;
  for (const int c : cells) {
    if (mesh.cell_quality(c) >= wanted) continue;
    const auto n = mesh.cell(c);
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = n[i];
      const int b = n[(i + 1) % 3];
      const auto other = mesh.across(c, a, b);
      if (!other || mesh.is_locked_edge(a, b) || track.has_edge(a, b)) continue;
      const int mine = n[(i + 2) % 3];
      const int far = mesh.opposite(*other, a, b);
      const double before = std::min(mesh.cell_quality(c), mesh.cell_quality(*other));
      const double after = std::min(quality(mesh.point(mine), mesh.point(a), mesh.point(far)),
                                    quality(mesh.point(mine), mesh.point(far), mesh.point(b)));
      if (after <= std::max(worth_it * before, before + 1e-3)) continue;
      const double gain = after - before;
      const ReferencePoint middle = midpoint(mesh.point(a), mesh.point(b));
      // Ties by position, so that every numbering takes the same edge.
      constexpr double equal = 1e-6;
      const bool tied = std::abs(gain - best_gain) <= equal;
      const bool further = Axis::across(middle) > Axis::across(best_middle) ||
                           (Axis::across(middle) == Axis::across(best_middle) &&
                            Axis::along(middle) > Axis::along(best_middle));
      if (!best || (tied ? further : gain > best_gain)) {
        best_gain = gain;
        best = EdgeFlip{a, b};
        best_middle = middle;
      }
    }
  }
  return best;
}

std::vector<int> rewrite(Mesh& mesh, const NeedleEdits& edits) {
  std::vector<int> touched;
  for (const auto& move : edits.moves) {
    mesh.move_node(move.node, move.x);
    const auto around = mesh.cells_around(move.node);
    touched.insert(touched.end(), around.begin(), around.end());
  }
  for (const auto& edge : edits.flips) {
    const auto both = mesh.cells_with(edge.a, edge.b);
    mesh.flip_edge(edge.a, edge.b);
    touched.insert(touched.end(), both.begin(), both.end());
  }
  return touched;
}

std::vector<EdgeFlip> repair(Mesh& mesh,
                             const Track& track,
                             std::vector<int>& touched_cells,
                             double wanted) {
  constexpr int most_repairs = 20;
  std::vector<EdgeFlip> flips;
  for (int i = 0; i < most_repairs; ++i) {
    const auto edge = best_flip(mesh, track, touched_cells, wanted);
    if (!edge) break;
    const auto both = mesh.cells_with(edge->a, edge->b);
    touched_cells.insert(touched_cells.end(), both.begin(), both.end());
    mesh.flip_edge(edge->a, edge->b);
    flips.push_back(*edge);
  }
  return flips;
}

}  // namespace stylet
