// Reads the text of a Gmsh file: ASCII, formats 2.2 and 4.1.
//
// Triangles with a physical surface become cells, lines with a physical curve become facets (outer
// boundaries and inner curves alike). If the file has tetrahedra, these are the cells and the
// triangles of physical surfaces are the facets. Nodes that no cell uses are dropped.
// Coordinates are multiplied by `scale`, so that the mesh is in metres.
// Errors: InputError "name:line: ..." for anything that is not such a file.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

#include <string>

namespace stylet {

/// `name` is only for messages; the mesh is not yet validated.
MeshData read_gmsh(const std::string& name, const std::string& text, double scale = 1);

}  // namespace stylet
