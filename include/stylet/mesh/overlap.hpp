// Whether the cells of a mesh cover each point once and hang together.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

namespace stylet {

/// Of a 2D mesh whose triangles are counter-clockwise and whose edges have one or two, on opposite
/// sides. Throws InputError that names the source and a place: nodes or edges that lie on each other
/// unshared, triangles that lie on others, parts that do not hang together by an edge. An immersed
/// sheet without branch points covers each point once if its boundary does not meet itself, so only
/// angles at nodes and the boundary are looked at: O(N) and about O(B sqrt(B)) for B boundary edges.
void check_overlaps(const MeshData& mesh);

/// The same of tetrahedra that are right-handed, with one or two of them at a face, on opposite sides;
/// solid angles at nodes and the outer triangles are looked at. Parts that hang together at an edge or a
/// node only are refused. O(N log N).
void check_overlaps_in_space(const MeshData& mesh);

}  // namespace stylet
