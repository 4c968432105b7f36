#include "stylet/solvers/modes.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/petsc/owned.hpp"
#include "stylet/petsc/session.hpp"

#include <slepceps.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace stylet {

namespace {

using OwnedEps = Owned<EPS, EPSDestroy>;

OwnedIs free_rows(const TissueOperator& tissue, std::span<const int> held_dofs) {
  std::vector<PetscInt> free;
  for (int dof = tissue.first_dof(); dof < tissue.end_dof(); ++dof) {
    if (!std::ranges::binary_search(held_dofs, dof)) free.push_back(dof);
  }
  OwnedIs rows;
  check(ISCreateGeneral(tissue.comm(), static_cast<PetscInt>(free.size()), free.data(),
                        PETSC_COPY_VALUES, rows.put()));
  return rows;
}

// The rows and columns of the free dofs.
OwnedMat reduced(Mat matrix, IS free) {
  OwnedMat part;
  check(MatCreateSubMatrix(matrix, free, free, MAT_INITIAL_MATRIX, part.put()));
  return part;
}

}  // namespace

std::vector<double> natural_frequencies(const TissueOperator& tissue,
                                        std::span<const int> held_dofs,
                                        int n) {
  const OwnedIs rows = free_rows(tissue, held_dofs);
  OwnedMat k = reduced(tissue.stiffness(), rows.get());
  OwnedMat m;
  if (tissue.mass() != nullptr) {
    m = reduced(tissue.mass(), rows.get());
  } else {
    check(MatDuplicate(k.get(), MAT_DO_NOT_COPY_VALUES, m.put()));
    check(MatZeroEntries(m.get()));
    Vec part = nullptr;
    check(VecGetSubVector(tissue.lumped_mass(), rows.get(), &part));
    check(MatDiagonalSet(m.get(), part, INSERT_VALUES));
    check(VecRestoreSubVector(tissue.lumped_mass(), rows.get(), &part));
  }
  PetscReal stiffness = 0;
  PetscReal mass = 0;
  check(MatNorm(k.get(), NORM_INFINITY, &stiffness));
  check(MatNorm(m.get(), NORM_INFINITY, &mass));

  OwnedEps eps;
  check(EPSCreate(tissue.comm(), eps.put()));
  check(EPSSetOperators(eps.get(), k.get(), m.get()));
  check(EPSSetProblemType(eps.get(), EPS_GHEP));
  // The second copy of a double frequency enters the Krylov space only through round-off, when n
  // others may have converged already: ask for a few more.
  constexpr PetscInt spare = 4;
  PetscInt size = 0;
  check(MatGetSize(k.get(), &size, nullptr));
  check(EPSSetDimensions(eps.get(), std::min<PetscInt>(n + spare, size), PETSC_DEFAULT,
                         PETSC_DEFAULT));
  check(EPSSetWhichEigenpairs(eps.get(), EPS_TARGET_MAGNITUDE));
  // Far below every elastic mode, far above round-off of K.
  constexpr double below_zero = -1e-7;
  check(EPSSetTarget(eps.get(), below_zero * stiffness / mass));
  constexpr double tolerance = 1e-10;
  check(EPSSetTolerances(eps.get(), tolerance, PETSC_DEFAULT));
  ST st = nullptr;
  check(EPSGetST(eps.get(), &st));
  check(STSetType(st, STSINVERT));
  KSP ksp = nullptr;
  PC pc = nullptr;
  check(STGetKSP(st, &ksp));
  check(KSPSetType(ksp, KSPPREONLY));
  check(KSPGetPC(ksp, &pc));
  check(PCSetType(pc, PCCHOLESKY));
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  check_options(EPSSetFromOptions(eps.get()));
  check_options(EPSSolve(eps.get()));
  PetscInt found = 0;
  check(EPSGetConverged(eps.get(), &found));
  if (found < n) {
    throw NumericalError("only " + std::to_string(found) + " of " + std::to_string(n) +
                         " modes converged");
  }
  constexpr double largest_error = 1e-6;
  std::vector<double> frequencies;
  for (int i = 0; i < found; ++i) {
    PetscScalar value = 0;
    check(EPSGetEigenvalue(eps.get(), i, &value, nullptr));
    PetscReal error = 0;
    check(EPSComputeError(eps.get(), i, EPS_ERROR_RELATIVE, &error));
    // Beside a frequency of zero no residual is small: there round-off is what is right.
    PetscReal backward = 0;
    check(EPSComputeError(eps.get(), i, EPS_ERROR_BACKWARD, &backward));
    constexpr double round_off = 1e-13;
    if (error > largest_error && backward > round_off) {
      throw NumericalError("a mode is inaccurate: its residual is " + exact(error) +
                           " of it, where at most 1e-6 is right; are solver options to blame?");
    }
    frequencies.push_back(std::sqrt(std::max(0.0, value)));
  }
  std::ranges::sort(frequencies);
  frequencies.resize(static_cast<std::size_t>(n));
  return frequencies;
}

double largest_frequency_squared(const TissueOperator& tissue, const ConstraintSet& constraints) {
  std::vector<int> held;
  for (const auto& dof : constraints.dofs) held.push_back(dof.dof);
  std::ranges::sort(held);
  const OwnedIs rows = free_rows(tissue, held);
  const auto free_part = [&](Vec whole, Vec part) {
    Vec view = nullptr;
    check(VecGetSubVector(whole, rows.get(), &view));
    check(VecCopy(view, part));
    check(VecRestoreSubVector(whole, rows.get(), &view));
  };
  // A = M^-1/2 K M^-1/2 has the same eigenvalues and is symmetric: nothing to factor.
  OwnedMat a = reduced(tissue.stiffness(), rows.get());
  OwnedVec scale;
  check(MatCreateVecs(a.get(), scale.put(), nullptr));
  free_part(tissue.lumped_mass(), scale.get());
  check(VecSqrtAbs(scale.get()));
  check(VecReciprocal(scale.get()));
  check(MatDiagonalScale(a.get(), scale.get(), scale.get()));

  OwnedEps eps;
  check(EPSCreate(tissue.comm(), eps.put()));
  check(EPSSetOperators(eps.get(), a.get(), nullptr));
  check(EPSSetProblemType(eps.get(), EPS_HEP));
  check(EPSSetWhichEigenpairs(eps.get(), EPS_LARGEST_REAL));
  constexpr double tolerance = 1e-8;
  check(EPSSetTolerances(eps.get(), tolerance, PETSC_DEFAULT));
  OwnedVec across;
  if (constraints.mean) {
    // w . u = 0 is orthogonality to M^-1/2 w in the scaled space, which SLEPc's deflation keeps.
    OwnedVec weights = tissue.make_vector();
    check(VecSet(weights.get(), 0));
    for (const auto& [dof, weight] : constraints.mean->weights) {
      set_owned(weights.get(), dof, weight);
    }
    check(VecDuplicate(scale.get(), across.put()));
    free_part(weights.get(), across.get());
    check(VecPointwiseMult(across.get(), across.get(), scale.get()));
    Vec space[1] = {across.get()};
    check(EPSSetDeflationSpace(eps.get(), 1, space));
  }
  check_options(EPSSetFromOptions(eps.get()));
  check_options(EPSSolve(eps.get()));
  PetscInt found = 0;
  check(EPSGetConverged(eps.get(), &found));
  if (found < 1) throw NumericalError("the largest frequency did not converge");
  PetscScalar squared = 0;
  check(EPSGetEigenvalue(eps.get(), 0, &squared, nullptr));
  return squared;
}

}  // namespace stylet
