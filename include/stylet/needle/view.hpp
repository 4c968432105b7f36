// What the needle sees and what it asks for: a few nodes, with the same bits on every rank.
#pragma once

#include "stylet/geometry/points.hpp"

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace stylet {

/// Start of the step.
struct NodeState {
  Vector2 u;  ///< m
  Vector2 v;  ///< m/s
  Vector2 a;  ///< m/s^2
};

/// End of the step as tried.
struct NodeTrial {
  Vector2 u;         ///< m
  Vector2 v;         ///< m/s
  Vector2 reaction;  ///< N, needed by the prescribed dofs
  Vector2 working;   ///< N, as in Trial
  Vector2 settled;   ///< N, as in Trial
};

/// Values of some nodes.
template <class Value>
class NodeTable {
 public:
  NodeTable() = default;
  /// nodes: ascending.
  NodeTable(std::vector<int> nodes, std::vector<Value> values)
      : nodes_(std::move(nodes)), values_(std::move(values)) {}
  [[nodiscard]] const Value& at(int node) const {
    const auto found = std::ranges::lower_bound(nodes_, node);
    if (found == nodes_.end() || *found != node) throw std::out_of_range("node is not watched");
    return values_[static_cast<std::size_t>(found - nodes_.begin())];
  }
  [[nodiscard]] const std::vector<int>& nodes() const { return nodes_; }

 private:
  std::vector<int> nodes_;
  std::vector<Value> values_;
};

using NeedleView = NodeTable<NodeState>;
using TrialView = NodeTable<NodeTrial>;

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
