// Structured tetrahedra on a box, with ellipsoids as inner regions.
//
// (columns + 1) x (rows + 1) x (layers + 1) nodes, six tetrahedra around a diagonal of every brick, which
// is mirrored in its neighbours so that no direction is stiffer than its mirror image. Named surfaces: left,
// right, bottom, top, back, front, and `<region>_outline` for each inner region. Where inner regions
// lie in each other the later one counts. Errors: InputError that names the parameter, and one where
// the tetrahedra of an inner region do not have its volume by 5 %.
#pragma once

#include "stylet/mesh/mesh_data.hpp"
#include "stylet/mesh/parameters.hpp"

namespace stylet {

/// The result depends on the parameters only, to the last bit.
MeshData make_box(const BoxMesh& parameters);

}  // namespace stylet
