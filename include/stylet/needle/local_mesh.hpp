// A copy of the cells near some nodes, to try edits on before they are asked for.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/track.hpp"
#include "stylet/needle/view.hpp"

#include <optional>
#include <span>
#include <vector>

namespace stylet {

class LocalMesh {
 public:
  /// The cells around the nodes and around their neighbours. Its rim counts as locked, as do the
  /// edges that the mesh locks.
  LocalMesh(const Mesh& mesh, std::span<const int> nodes);

  [[nodiscard]] Mesh& mesh() { return mesh_; }
  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  /// -1 for a node that is not in the copy.
  [[nodiscard]] int local(int node) const;
  [[nodiscard]] int global(int node) const { return nodes_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] EdgeFlip global(EdgeFlip edge) const { return {global(edge.a), global(edge.b)}; }
  /// The track in the numbers of the copy.
  [[nodiscard]] Track local(const Track& track) const;

 private:
  std::vector<int> nodes_;  ///< ascending
  Mesh mesh_;
};

/// Does the edits; returns the cells that changed, some more than once.
std::vector<int> rewrite(Mesh& mesh, const NeedleEdits& edits);

/// Flips, one after the other, that raise the worst quality of the touched cells until none is below
/// `wanted` or nothing is to be gained; done in the mesh, and added to the touched cells.
std::vector<EdgeFlip> repair(Mesh& mesh,
                             const Track& track,
                             std::vector<int>& touched_cells,
                             double wanted);

/// The best such flip: of an edge of a touched triangle below `wanted`, never of a locked edge or one
/// of the track. Of equally good ones the one higher and further ahead.
[[nodiscard]] std::optional<EdgeFlip> best_flip(const Mesh& mesh,
                                                const Track& track,
                                                std::span<const int> touched_cells,
                                                double wanted);

}  // namespace stylet
