// The needle's path in the reference mesh: a chain of nodes from the skin to the deepest point.
#pragma once

#include "stylet/mesh/mesh.hpp"

#include <span>
#include <vector>

namespace stylet {

enum class Contact { stick, slip };

/// A node of the path. attached: the needle is there and holds it on its axis.
struct ShaftNode {
  int node;
  bool attached = true;
  Contact contact = Contact::stick;
  double slip_sign = 1;  ///< of the friction force on the tissue, along
  int changes = 0;       ///< of contact in this step since the mesh was last edited
};

class Track {
 public:
  [[nodiscard]] bool empty() const { return nodes_.empty(); }
  [[nodiscard]] std::size_t size() const { return nodes_.size(); }
  [[nodiscard]] std::span<ShaftNode> nodes() { return nodes_; }
  [[nodiscard]] std::span<const ShaftNode> nodes() const { return nodes_; }
  [[nodiscard]] int tip() const { return nodes_.back().node; }
  [[nodiscard]] int behind_tip() const { return nodes_[nodes_.size() - 2].node; }
  void push(ShaftNode node) { nodes_.push_back(node); }
  [[nodiscard]] bool holds(int node) const;
  /// True if the nodes follow each other on the path.
  [[nodiscard]] bool has_edge(int a, int b) const;

  /// Distance of each node from the deepest one along the path (m), skin first.
  [[nodiscard]] std::vector<double> distances(const Mesh& mesh) const;

  /// Integrals of the nodes' hat functions along the path over distances [from, to] from the deepest
  /// node (m). What belongs to a node that is not attached goes to its neighbour towards the skin.
  [[nodiscard]] std::vector<double> lengths(const Mesh& mesh, double from, double to) const;

  void archive(Archive& archive);

 private:
  std::vector<ShaftNode> nodes_;
};

}  // namespace stylet
