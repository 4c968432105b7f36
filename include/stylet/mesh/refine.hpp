// Nested refinement: each triangle is split in four at its edge midpoints.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

namespace stylet {

/// Splits `times` times. Coarse nodes keep their numbers; cell c becomes cells 4c .. 4c + 3 (three
/// corners, then the middle), facet f becomes facets 2f and 2f + 1. New nodes lie on the coarse
/// edges also where a curve was round. Errors: InputError for tetrahedra, for a negative `times`
/// and for more cells than an int can count.
MeshData refine(const MeshData& coarse, int times);

}  // namespace stylet
