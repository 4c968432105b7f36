// Reads the bytes of a Gmsh file: formats 2 and 4.1, ASCII and binary, and ASCII 4.0.
//
// Triangles with a physical surface become cells, lines with a physical curve become facets (outer
// boundaries and inner curves alike). If the file has tetrahedra, these are the cells and the
// triangles of physical surfaces are the facets. A physical group without a name is called by its
// number. Nodes that no cell uses are dropped, and curves that need them are stray.
// Coordinates are multiplied by `scale`, so that the mesh is in metres.
// Errors: InputError "name:line: ..." (binary files: "name: byte N: ...") for anything that is not
// such a file.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

#include <string>

namespace stylet {

/// `name` is only for messages; the mesh is not yet validated. Cells of more dimensions than `most_dim`
/// are refused before anything else about them.
MeshData read_gmsh(const std::string& name,
                   const std::string& text,
                   double scale = 1,
                   int most_dim = 3);

}  // namespace stylet
