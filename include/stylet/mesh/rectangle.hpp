// Structured triangles on a rectangle, with inner regions and named inner curves.
//
// (columns + 1) x (rows + 1) nodes, 2 x columns x rows triangles. Named curves: left, right,
// bottom, top, `<region>_outline` for each inner region, and the inner curves of the parameters.
// Where inner regions lie in each other the later one counts for the cells; outlines stay whole.
// Errors: InputError that names the parameter; one that says which of columns and rows to raise
// if a triangle is too flat or an inner region is met too coarsely.
#pragma once

#include "stylet/mesh/mesh_data.hpp"
#include "stylet/mesh/parameters.hpp"

namespace stylet {

/// The result depends on the parameters only, to the last bit.
MeshData make_rectangle(const RectangleMesh& parameters);

}  // namespace stylet
