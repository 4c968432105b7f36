// Fields of a snapshot that every cell has one value of.
#pragma once

#include "stylet/output/chunk.hpp"
#include "stylet/output/snapshots.hpp"
#include "stylet/simulation/simulation.hpp"

#include <span>
#include <vector>

namespace stylet {

/// Adds stress, strain energy density and region of these rows of cells, which are in the order of the
/// mesh's source, in the scene's frame. u: displacements of all dofs (m).
void add_cell_fields(const Simulation& simulation,
                     std::span<const int> new_of_old_cell,
                     Range rows,
                     const std::vector<double>& u,
                     Snapshot& snapshot);

}  // namespace stylet
