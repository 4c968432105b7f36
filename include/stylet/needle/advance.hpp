// How the tip advances in the reference mesh: direction, element ahead, hand-over, entry.
//
// All functions are pure and return edits; ties are broken by position, never by node number, so
// that every numbering (every number of ranks) takes the same decision.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/axis.hpp"
#include "stylet/needle/local_mesh.hpp"
#include "stylet/needle/track.hpp"
#include "stylet/needle/view.hpp"

#include <optional>

namespace stylet {

/// The tip's place in the mesh at the start of an advance.
struct AdvanceBase {
  ReferencePoint p;  ///< tip
  Vector2 r;         ///< unit direction of advance, F^-1 d normalised
  int cell = -1;     ///< element ahead
  int j = -1;        ///< ends of the edge ahead
  int k = -1;
  double distance = 0;   ///< to the edge ahead along r (m)
  double reach = 0;      ///< advance that the elements around the tip bear (m), < distance
  double hand_over = 0;  ///< advance at which the tip hands over (m), <= distance; may be < 0
  NodeState at_tip;      ///< fields at p and where r meets the edge ahead
  NodeState at_edge;
  bool fell_back = false;  ///< r is d because F was no help
};

/// The element ahead of the tip node and the way through it. None if the tip stands at the boundary.
[[nodiscard]] std::optional<AdvanceBase> find_way(const Mesh& mesh,
                                                  const Track& track,
                                                  const Axis& axis,
                                                  const NeedleView& start);

/// The tip node moved by b along r.
[[nodiscard]] NodeEdit advanced(const AdvanceBase& base, int tip, double b);

/// Which node becomes the new tip, and the edits: it goes to the tip's place, the old tip node goes
/// back to the middle of the last shaft edge; flips raise the quality of what is left.
struct HandOver {
  int new_tip = -1;
  NeedleEdits edits;
  double quality = 0;  ///< worst of the touched triangles
};

/// From the tip's present place. At the skin (a track of one node) the skin node stays and the new
/// tip goes ahead by half the distance to the edge. None if no node may move.
[[nodiscard]] std::optional<HandOver> plan_hand_over(const Mesh& mesh,
                                                     const Track& track,
                                                     const AdvanceBase& base,
                                                     const NeedleView& start);

/// The flip of an edge of an element at the tip that lets it advance furthest. None if no flip gains
/// anything.
[[nodiscard]] std::optional<EdgeFlip> plan_passage(const Mesh& mesh,
                                                   const Track& track,
                                                   const AdvanceBase& base);

/// The skin node that slides to where the axis first meets the boundary from outside. Throws
/// InputError if the axis misses the tissue or meets it at a corner.
struct Entry {
  int node;
  int neighbour;    ///< the other end of the boundary edge
  double fraction;  ///< way from node to neighbour
  ReferencePoint x;
};
[[nodiscard]] Entry find_entry(const Mesh& mesh, const Axis& axis, const std::string& needle);

/// Worst quality of the cells around the moved nodes, as if the moves were done.
[[nodiscard]] double quality_after(const Mesh& mesh, std::span<const NodeEdit> moves);

}  // namespace stylet
