// Nested refinement: each triangle is split in four at its edge midpoints, each tetrahedron in eight.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

namespace stylet {

/// Splits `times` times. Coarse nodes keep their numbers. Triangle c becomes triangles 4c .. 4c + 3
/// (three corners, then the middle), edge f becomes edges 2f and 2f + 1. Tetrahedron c becomes
/// tetrahedra 8c .. 8c + 7: four corners, and the octahedron between them cut along the
/// diagonal that leaves the best ones; a triangle of a surface becomes four. New nodes lie on the coarse edges also where a boundary was
/// round. Errors: InputError for a negative `times` and
/// for more cells than an int can count.
MeshData refine(const MeshData& coarse, int times);

}  // namespace stylet
