// A copy of an operator in which some dofs are cut off from the others.
#pragma once

#include "stylet/petsc/owned.hpp"

#include <span>

namespace stylet {

class Eliminated {
 public:
  /// Collective. Copies A, and replaces rows and columns of owned dofs (local indices) by a diagonal.
  void take(Mat a, std::span<const PetscInt> dofs);
  [[nodiscard]] Mat matrix() const { return matrix_.get(); }

 private:
  PetscObjectId a_id_ = 0;
  OwnedMat matrix_;
  OwnedVec diagonal_;
};

}  // namespace stylet
