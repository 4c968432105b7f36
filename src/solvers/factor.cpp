#include "stylet/solvers/factor.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/solvers/cholesky.hpp"

namespace stylet {

namespace {

// GAMG takes 1.1 times its estimate of the largest eigenvalue for a bound. Too low a bound makes its
// Chebyshev smoother indefinite, which ends CG: seen on 19,616 triangles around a needle.
void widen_smoother(PC pc) {
  PetscBool multigrid = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCGAMG, &multigrid));
  constexpr const char* option = "-mg_levels_ksp_chebyshev_esteig";
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, option, &given));
  if (multigrid == PETSC_TRUE && given == PETSC_FALSE) {
    check(PetscOptionsSetValue(nullptr, option, "0,0.1,0,1.3"));
  }
}

}  // namespace

// One rank: CHOLMOD. Several: each factors the whole operator with it, so that a solve is one exchange
// of vectors; a distributed factor waits for the other ranks at every front, which costs more than
// the arithmetic on small problems. Where the memory of all ranks is needed: MUMPS.
Factor::Factor(MPI_Comm comm, PetscInt n_dofs) {
  check(PCCreate(comm, pc_.put()));
  PC factor = pc_.get();
  const bool replicated = size_of(comm) > 1 && Cholesky::fits(comm, n_dofs);
  if (replicated) {
    KSP whole = nullptr;
    check(PCSetType(pc_.get(), PCREDUNDANT));
    check(PCRedundantGetKSP(pc_.get(), &whole));
    check(KSPSetType(whole, KSPPREONLY));
    check(KSPGetPC(whole, &factor));
  }
  check(PCSetType(factor, PCCHOLESKY));
  check(PCFactorSetMatSolverType(
      factor, replicated || size_of(comm) == 1 ? MATSOLVERCHOLMOD : MATSOLVERMUMPS));
}

void Factor::set_up(Mat a, std::span<const PetscInt> eliminated) {
  static const LogEvent event("StyletFactor");
  const LogScope scope(event);
  operator_.take(a, eliminated);
  check(PCSetOperators(pc_.get(), operator_.matrix(), operator_.matrix()));
  if (!configured_) {
    check(PCSetFromOptions(pc_.get()));
    widen_smoother(pc_.get());
  }
  check(PCSetUp(pc_.get()));
  PCFailedReason reason = PC_NOERROR;
  check(PCGetFailedReason(pc_.get(), &reason));
  if (reason != PC_NOERROR) {
    throw NumericalError(
        "the step's operator cannot be factored: it is singular or indefinite (is "
        "the tissue supported, and are all elements valid?)");
  }
  configured_ = true;
}

void Factor::apply(Vec b, Vec x) const {
  check(PCApply(pc_.get(), b, x));
}

}  // namespace stylet
