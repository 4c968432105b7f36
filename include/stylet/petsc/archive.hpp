// Fields of dofs in an archive.
#pragma once

#include "stylet/base/archive.hpp"

#include <petscvec.h>

#include <string>

namespace stylet {

/// Collective. A vector of dofs (dim node + component), in the order of the mesh's source.
void archive_field(Archive& archive, const std::string& name, Vec field);

}  // namespace stylet
