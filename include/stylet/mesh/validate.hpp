// Checks a mesh as a reader or a generator left it, and turns clockwise cells round.
//
// After it: every cell has positive measure and counter-clockwise nodes (in 3D: right-handed), an
// inner edge (3D: face) has exactly one cell on each side, every facet is an edge of a cell, and in 2D
// the mesh is one part that covers each point once (overlap.hpp). O(N log N). Errors: InputError that names the source, the cell (from 1), its nodes (from 1) and
// where it is.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

namespace stylet {

/// Turns clockwise cells round (of Gmsh surfaces some may be). A cell that is clockwise because the
/// mesh is folded there then lies on others, which is an error.
void validate(MeshData& mesh);

}  // namespace stylet
