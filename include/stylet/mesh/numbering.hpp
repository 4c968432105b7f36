// Which rank owns which node, and the order of nodes and cells.
//
// METIS splits the node graph (nodes are neighbours if a cell has both); inside each rank a reverse
// Cuthill-McKee order keeps the matrix narrow. The result depends on the mesh and the number of
// ranks only, so every rank computes the same.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

#include <vector>

namespace stylet {

struct Numbering {
  std::vector<int> new_of_old;
  std::vector<int> first_node;  ///< rank r owns new nodes first_node[r] .. first_node[r + 1] - 1
};

/// Errors: InputError for fewer than one rank or more ranks than nodes, Error if METIS fails.
Numbering number_nodes(const MeshData& mesh, int n_ranks);

/// The mesh in the new numbers. Cells are sorted by their smallest node, so that a loop over them
/// walks through memory; each keeps its cyclic order of nodes. Facets keep their order.
MeshData renumber(const MeshData& mesh,
                  const Numbering& numbering,
                  std::vector<int>& old_cell_of_new);

}  // namespace stylet
