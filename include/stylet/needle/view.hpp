// What the needle's way through the mesh sees and asks for: a few nodes, with the same bits on every rank.
#pragma once

#include "stylet/geometry/points.hpp"
#include "stylet/needle/value_table.hpp"

#include <vector>

namespace stylet {

/// Start of the step.
struct NodeState {
  Vector2 u;  ///< m
  Vector2 v;  ///< m/s
  Vector2 a;  ///< m/s^2
};

using NeedleView = ValueTable<NodeState>;

/// A node goes to another place of the reference mesh and takes the fields of that place.
struct NodeEdit {
  int node;
  ReferencePoint x;
  NodeState state;
};

struct EdgeFlip {
  int a;
  int b;
};

/// Moves first, all at once; then flips, in order.
struct NeedleEdits {
  std::vector<NodeEdit> moves;
  std::vector<EdgeFlip> flips;
  [[nodiscard]] bool empty() const { return moves.empty() && flips.empty(); }
};

inline NodeState interpolate(double s, const NodeState& from, const NodeState& to) {
  const auto mix = [s](Vector2 a, Vector2 b) { return a + s * (b - a); };
  return {mix(from.u, to.u), mix(from.v, to.v), mix(from.a, to.a)};
}

}  // namespace stylet
