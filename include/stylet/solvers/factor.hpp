// A preconditioner made from an operator with some dofs eliminated: a direct factor, or what PETSc's
// options -pc_* ask for.
#pragma once

#include "stylet/solvers/eliminated.hpp"

#include <span>

namespace stylet {

class Factor {
 public:
  /// Collective. n_dofs: of all ranks.
  Factor(MPI_Comm comm, PetscInt n_dofs);
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;
  ~Factor() = default;

  /// Collective. eliminated: owned dofs (local indices). Throws NumericalError if A is singular or
  /// indefinite and the preconditioner minds.
  void set_up(Mat a, std::span<const PetscInt> eliminated);

  /// Collective. x = inverse times b.
  void apply(Vec b, Vec x) const;

 private:
  OwnedPc pc_;
  Eliminated operator_;
  bool configured_ = false;
};

}  // namespace stylet
