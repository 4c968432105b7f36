// Checks a mesh as a reader or a generator left it, and turns its cells the same way round.
//
// After it: every cell has positive measure and counter-clockwise nodes (in 3D: right-handed), an
// inner edge (3D: face) has exactly one cell on each side, every facet is an edge (3D: face) of a cell,
// and the mesh is one part that covers each point once (overlap.hpp). O(N log N). Errors: InputError that
// names the source, the cell, its nodes and where it is, in the numbers and lines of the file where the
// mesh has its origin, else counted from 1.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

namespace stylet {

/// Cells may be given either way round; one that is folded over its neighbour then lies on the same
/// side of their edge, which is an error. Curves with a facet that is no edge of a cell become stray.
void validate(MeshData& mesh);

}  // namespace stylet
