// Checks a mesh as a reader or a generator left it, and turns clockwise regions round.
//
// After it: every cell has positive measure and counter-clockwise nodes (in 3D: right-handed), an
// inner edge (3D: face) has exactly one cell on each side, and every facet is an edge of a cell.
// O(N log N). Errors: InputError that names the source, the cell (from 1), its nodes (from 1) and
// where it is.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

namespace stylet {

/// Flips the cells of a region that are all clockwise (Gmsh surfaces may be); a lone clockwise cell
/// among others is an error.
void validate(MeshData& mesh);

}  // namespace stylet
