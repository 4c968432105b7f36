// A direct factor, or any other PC, of an operator with some dofs eliminated.
#pragma once

#include "stylet/petsc/owned.hpp"

#include <span>
#include <vector>

namespace stylet {

/// PETSc options -pc_* choose another PC.
class Factor {
 public:
  /// Collective. n_dofs: of all ranks.
  Factor(MPI_Comm comm, PetscInt n_dofs);
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;
  ~Factor() = default;

  /// True if `apply` will solve exactly, but for round-off, and nothing asks for an iteration: no
  /// option -ksp_* and no other PC than a factorisation.
  [[nodiscard]] static bool exact();

  /// Collective. Copies A, replaces rows and columns of owned eliminated dofs (local indices) by a
  /// diagonal, and factors. Throws NumericalError if that is singular or indefinite.
  void set_up(Mat a, std::span<const PetscInt> eliminated);
  /// The operator that was factored.
  [[nodiscard]] Mat matrix() const { return eliminated_.get(); }
  [[nodiscard]] int n_set_ups() const { return n_set_ups_; }

  /// Collective. x = inverse times b.
  void apply(Vec b, Vec x) const;

  /// Collective. Entries of the inverse, on every rank: [column * rows.size() + row].
  [[nodiscard]] std::vector<double> inverse_entries(std::span<const int> rows,
                                                    std::span<const int> columns) const;

 private:
  [[nodiscard]] PC own_copy() const;
  MPI_Comm comm_;
  PetscObjectId a_id_ = 0;
  OwnedPc pc_;
  OwnedMat eliminated_;
  OwnedVec work_;
  int n_set_ups_ = 0;
};

}  // namespace stylet
