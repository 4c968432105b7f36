// M x = b with some dofs given and one mean condition, for the consistent mass.
//
// Scaled by its diagonal the mass of linear simplices has eigenvalues in [1/2, 2] in 2D (Wathen, IMA J.
// Numer. Anal. 7, 1987), on any mesh: conjugate gradients with Jacobi take some thirty iterations and
// need no factor. With P the projection that zeroes given dofs they run on P M P. The mean condition
// takes a second solve with its weights as right-hand side. PETSc's options do not act on it.
#pragma once

#include "stylet/petsc/owned.hpp"
#include "stylet/solvers/constraint_set.hpp"

#include <span>
#include <vector>

namespace stylet {

class MassSolver {
 public:
  /// Collective.
  explicit MassSolver(MPI_Comm comm);
  MassSolver(const MassSolver&) = delete;
  MassSolver& operator=(const MassSolver&) = delete;
  ~MassSolver() = default;

  /// Collective. given: values of x at these dofs (the same list on all ranks); mean: weights and
  /// value, or null. reaction: M x - b - lambda w at the given dofs, zero elsewhere. Returns lambda
  /// (0 without a condition). Throws NumericalError if the condition cannot be met.
  double solve(Mat mass,
               Vec b,
               std::span<const DofValue> given,
               const MeanCondition* mean,
               Vec x,
               Vec reaction);

 private:
  static PetscErrorCode multiply(Mat shell, Vec x, Vec y);
  void adopt(Mat mass, Vec like);
  void run(Vec rhs, Vec x);
  void project(Vec x) const;

  MPI_Comm comm_;
  Mat mass_ = nullptr;
  PetscObjectId id_ = 0;
  std::vector<PetscInt> given_;  ///< owned local indices
  OwnedMat shell_;
  OwnedKsp ksp_;
  OwnedVec rhs_;
  OwnedVec work_;
  OwnedVec unit_;
  OwnedVec weights_;
  OwnedVec response_;
};

}  // namespace stylet
