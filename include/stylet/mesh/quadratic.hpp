// Quadratic tetrahedra with straight sides: corners, and a node in the middle of each edge.
//
// Geometry, regions and the location of points are those of the linear mesh; the further nodes are
// nodes like others for whoever asks for displacements.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

#include <array>
#include <cstddef>

namespace stylet {

/// Corners beside node 4 + e of a quadratic tetrahedron, in VTK's order.
inline constexpr std::array<std::array<std::size_t, 2>, 6> tetrahedron_edges{
    {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

/// Whether a corner is an end of the edge.
constexpr bool is_of_edge(std::size_t edge, std::size_t corner) {
  return tetrahedron_edges[edge][0] == corner || tetrahedron_edges[edge][1] == corner;
}

/// Gives tetrahedra their mid-edge nodes, numbered behind the corners in the order of the edges' ends.
void add_mid_edge_nodes(MeshData& mesh);

}  // namespace stylet
