// Whether the levels that a study is asked for can be run, before the first of them is.
#pragma once

#include "stylet/scene/scene.hpp"

#include <mpi.h>

#include <string>

namespace stylet {

/// Collective. verb: for messages. refine: of the finest mesh; steps: the shortest and the longest (s).
/// Throws InputError where the scene does not fit its mesh, where the finest one does not fit into memory
/// (how many levels do is named), and where a step is too short to count or too long for an insertion.
void require_levels(MPI_Comm comm,
                    const std::string& verb,
                    const Scene& scene,
                    double refine,
                    double shortest,
                    double longest);

}  // namespace stylet
