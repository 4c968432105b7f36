// A x = b with some dofs given and one mean condition, as KSP solves.
//
// With S the prescribed dofs and P the projection that zeroes them, conjugate gradients run on
// P A P, preconditioned by P F^-1 P, where F is a factor of A at an earlier time with the prescribed
// dofs of then eliminated. While nothing changed F is exact (one iteration); after edits and contact
// changes it stays good; it is made anew when a solve took more than `worn_out` iterations. The mean
// condition takes a second solve with its weights as right-hand side.
// PETSc options: -ksp_* for the iteration, -pc_* for F (any PC: gamg, hypre, jacobi ...).
#pragma once

#include "stylet/petsc/owned.hpp"
#include "stylet/solvers/constraint_set.hpp"
#include "stylet/solvers/factor.hpp"

#include <optional>
#include <span>
#include <vector>

namespace stylet {

class ConstrainedSolver {
 public:
  /// Collective. rtol: of the preconditioned residual.
  explicit ConstrainedSolver(MPI_Comm comm, double rtol = 1e-11);
  ConstrainedSolver(const ConstrainedSolver&) = delete;
  ConstrainedSolver& operator=(const ConstrainedSolver&) = delete;
  ~ConstrainedSolver() = default;

  struct Result {
    double lambda = 0;
    int iterations = 0;
  };

  /// Collective. given: values of x at prescribed dofs (the same list on all ranks); mean: weights
  /// and value, or null. x: first guess in, solution out. reaction: A x - b - lambda w at the
  /// prescribed dofs, zero elsewhere. A may have
  /// changed since the last call. Throws NumericalError if KSP does not converge or the condition cannot be met.
  Result solve(Mat a,
               Vec b,
               std::span<const DofValue> given,
               const MeanCondition* mean,
               Vec x,
               Vec reaction);

  /// The next solve factors again (a new time step, a new operator).
  void forget() { stale_ = true; }

 private:
  static PetscErrorCode multiply(Mat shell, Vec x, Vec y);
  static PetscErrorCode precondition(PC shell, Vec x, Vec y);
  void adopt(Mat a, Vec like);
  /// scale: the largest right-hand side so far, that of the first guess included: beside them a
  /// right-hand side may be mere round-off.
  int run(Vec rhs, Vec x, const char* what, double& scale);
  void require_solved(Vec rhs, Vec x, const char* what, double allowed);
  void project(Vec x) const;

  MPI_Comm comm_;
  double rtol_;
  Mat a_ = nullptr;
  PetscObjectId a_id_ = 0;
  std::vector<PetscInt> prescribed_;  ///< owned local indices
  OwnedMat shell_;
  std::optional<Factor> factor_;
  OwnedKsp ksp_;
  OwnedVec rhs_;
  OwnedVec work_;
  OwnedVec unit_;
  OwnedVec weights_;
  OwnedVec response_;
  OwnedVec residual_;
  double largest_rhs_ = 0;
  bool stale_ = true;
};

}  // namespace stylet
