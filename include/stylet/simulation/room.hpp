// Whether the mesh of a scene finds room in memory, before it is made.
#pragma once

#include "stylet/scene/scene.hpp"

#include <mpi.h>

#include <string>

namespace stylet {

/// Bytes that one rank needs for a mesh of so many triangles or tetrahedra, about (jobs/README.md has
/// what was measured): the mesh with its operators, and a factor, or its share of one, or multigrid where the
/// steps solve. ranks: of all machines; memory: memory_for_solvers.
[[nodiscard]] double bytes_needed(const Scene& scene, double n_cells, int ranks, double memory);

/// What a refinement needs and what there is.
struct Room {
  std::string lack;  ///< what is missing, in words; empty if the mesh fits
  int finest = -1;   ///< the largest refine that fits; -1: not even the mesh itself
};
/// Collective. n_cells: of the mesh before it is refined. The ranks that share a machine share its
/// memory, and each holds the whole mesh.
[[nodiscard]] Room room_for(MPI_Comm comm, const Scene& scene, double n_cells, int refine);

/// Collective. Throws InputError where the scene's mesh, of so many cells before it is refined, does not
/// fit.
void require_room(MPI_Comm comm, const Scene& scene, double n_cells);

}  // namespace stylet
