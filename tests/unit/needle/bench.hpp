// A needle in tissue that does not move, without a solver: what it cuts is what it advances.
#pragma once

#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/numbering.hpp"
#include "stylet/mesh/rectangle.hpp"
#include "stylet/needle/needle.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

namespace stylet {

/// 8 x 6 cm.
inline MeshData tissue(int columns,
                       int rows,
                       double jitter = 0,
                       Diagonals d = Diagonals::alternating) {
  RectangleMesh p;
  p.width = 0.08;
  p.height = 0.06;
  p.columns = columns;
  p.rows = rows;
  p.jitter = jitter;
  p.diagonals = d;
  return make_rectangle(p);
}

/// The same mesh with its nodes in a random order and its cells sorted accordingly.
inline Mesh permuted(const MeshData& data, unsigned seed) {
  Numbering numbering;
  numbering.new_of_old.resize(static_cast<std::size_t>(data.n_nodes()));
  std::iota(numbering.new_of_old.begin(), numbering.new_of_old.end(), 0);
  std::mt19937 random(seed);
  std::ranges::shuffle(numbering.new_of_old, random);
  numbering.first_node = {0, data.n_nodes()};
  std::vector<int> old_cell;
  return Mesh(renumber(data, numbering, old_cell));
}

using Displacement = std::function<Vector2(ReferencePoint)>;

/// All nodes, displaced by a function of their place.
inline NeedleView view_of(const Mesh& mesh, const Displacement& u) {
  std::vector<int> nodes(static_cast<std::size_t>(mesh.n_nodes()));
  std::iota(nodes.begin(), nodes.end(), 0);
  std::vector<NodeState> states;
  for (const int node : nodes) states.push_back({u(mesh.point(node)), {}, {}});
  return {std::move(nodes), std::move(states)};
}

inline NeedleView still(const Mesh& mesh) {
  return view_of(mesh, [](ReferencePoint) { return Vector2{}; });
}

inline int node_at(const Mesh& mesh, ReferencePoint x) {
  int nearest = 0;
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    if (distance(mesh.point(node), x) < distance(mesh.point(nearest), x)) nearest = node;
  }
  return nearest;
}

/// A needle in rigid tissue: the tip is pushed through with any force asked for.
struct Bench {
  Mesh mesh;
  Motion motion;
  Needle needle;

  Bench(Mesh tissue_mesh, NeedleParameters parameters, NeedleTissue tissue = {})
      : mesh(std::move(tissue_mesh)),
        motion(parameters.motion),
        needle(mesh, std::move(parameters), std::move(tissue), false) {
    const Entry entry = find_entry(mesh, {needle.parameters().height}, "needle");
    rewrite(mesh, needle.enter(entry, still(mesh)));
    motion.enter(needle.skin(), Axis::along_sign);
  }

  /// One accepted step; after each round of edits `look` is called.
  void step(
      double h, double force, const std::function<void()>& look = [] {}) {
    const NeedleStep now = motion.next(h);
    needle.start_step(now);
    for (;;) {
      while (needle.wants_edit()) {
        rewrite(mesh, needle.plan(still(mesh)));
        look();
      }
      std::vector<int> points = needle.loaded_points();
      const TrackTrial trial(points, std::vector<PointTrial>(points.size()));
      // Where the first cut went too far ahead the tip waits for the needle without a force.
      const bool waits = Axis::along(mesh.point(needle.track().tip())) > now.to;
      const double lambda = needle.tip_contact() == TipContact::stick && !waits ? force : 0;
      if (!needle.review(trial, lambda)) continue;
      needle.commit(still_shaft(), trial, lambda);
      motion.taken(now);
      return;
    }
  }
  [[nodiscard]] TrackStart still_shaft() const {
    std::vector<int> points = needle.loaded_points();
    const std::size_t n = points.size();
    return {std::move(points), std::vector<TrackVector>(n)};
  }
};

inline NeedleParameters needle_at(double height, double depth, double tip_length = 0) {
  NeedleParameters p;
  p.name = "needle";
  p.height = height;
  p.cutting.cutting_force = 1;
  p.cutting.tip_length = tip_length;
  Action insert;
  insert.kind = ActionKind::insert;
  insert.speed = 0.02;
  insert.depth = depth;
  p.motion = {insert};
  return p;
}

}  // namespace stylet
