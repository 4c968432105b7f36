#include "stylet/solvers/constrained_solver.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

namespace stylet {

namespace {

// A solve costs 3 to 10 % of a factorisation in 2D, so beyond this a new factor pays.
constexpr int worn_out = 12;
constexpr int most_iterations = 2000;
// What options may make of the accuracy. The first bounds the preconditioned residual, the second
// the true one, which exceeds it by as much as the operator is ill-conditioned.
constexpr double largest_rtol = 1e-8;
constexpr double largest_residual = 1e-4;

double dot(Vec x, Vec y) {
  PetscScalar value = 0;
  check(VecDot(x, y, &value));
  return value;
}

}  // namespace

ConstrainedSolver::ConstrainedSolver(MPI_Comm comm, double rtol) : comm_(comm), rtol_(rtol) {
  check(KSPCreate(comm, ksp_.put()));
  check(KSPSetType(ksp_.get(), KSPCG));
  // The first guess may be worse than none by any factor, so there is no divergence limit.
  check(KSPSetTolerances(ksp_.get(), rtol_, 1e-300, 1e300, most_iterations));
  check(KSPSetInitialGuessNonzero(ksp_.get(), PETSC_TRUE));
  PC outer = nullptr;
  check(KSPGetPC(ksp_.get(), &outer));
  check(PCSetOptionsPrefix(outer, "projected_"));
  check(PCSetType(outer, PCSHELL));
  check(PCShellSetContext(outer, this));
  check(PCShellSetApply(outer, precondition));
  check(KSPSetFromOptions(ksp_.get()));
  PetscReal given = 0;
  check(KSPGetTolerances(ksp_.get(), &given, nullptr, nullptr, nullptr));
  if (given > largest_rtol) {
    throw InputError(
        "PETSc option -ksp_rtol: allowed: at most 1e-8, so that displacements can be "
        "relied on");
  }
}

PetscErrorCode ConstrainedSolver::multiply(Mat shell, Vec x, Vec y) {
  return guard([&] {
    void* context = nullptr;
    check(MatShellGetContext(shell, &context));
    const auto* self = static_cast<ConstrainedSolver*>(context);
    // KSP's vectors are zero at the prescribed dofs, so only the result needs projecting.
    check(MatMult(self->a_, x, y));
    self->project(y);
  });
}

PetscErrorCode ConstrainedSolver::precondition(PC shell, Vec x, Vec y) {
  return guard([&] {
    void* context = nullptr;
    check(PCShellGetContext(shell, &context));
    const auto* self = static_cast<ConstrainedSolver*>(context);
    self->factor_->apply(x, y);
    self->project(y);
  });
}

void ConstrainedSolver::project(Vec x) const {
  // On every rank, also where nothing is prescribed: it invalidates the norm that PETSc remembers,
  // and ranks that remember different norms part ways in KSPSolve.
  PetscScalar* values = nullptr;
  check(VecGetArray(x, &values));
  for (const PetscInt i : prescribed_) values[i] = 0;
  check(VecRestoreArray(x, &values));
}

void ConstrainedSolver::adopt(Mat a, Vec like) {
  PetscObjectId id = 0;
  check(PetscObjectGetId(reinterpret_cast<PetscObject>(a), &id));
  a_ = a;
  if (id == a_id_) return;
  a_id_ = id;
  PetscInt local = 0;
  PetscInt global = 0;
  check(VecGetLocalSize(like, &local));
  check(VecGetSize(like, &global));
  check(MatCreateShell(comm_, local, local, global, global, this, shell_.put()));
  check(MatShellSetOperation(shell_.get(), MATOP_MULT, reinterpret_cast<void (*)()>(multiply)));
  check(MatSetOption(shell_.get(), MAT_SYMMETRIC, PETSC_TRUE));
  check(KSPSetOperators(ksp_.get(), shell_.get(), shell_.get()));
  if (!factor_) factor_.emplace(comm_, global);
  for (OwnedVec* vec : {&rhs_, &work_, &weights_, &response_, &unit_, &residual_}) {
    check(VecDuplicate(like, vec->put()));
    check(VecSet(vec->get(), 0));
  }
  stale_ = true;
}

int ConstrainedSolver::run(Vec rhs, Vec x, const char* what, double& scale) {
  PetscReal size = 0;
  check(VecNorm(rhs, NORM_2, &size));
  if (size == 0) {  // KSP would stop somewhere between the first guess and zero
    check(VecSet(x, 0));
    return 0;
  }
  PetscReal guess = 0;
  check(MatMult(shell_.get(), x, residual_.get()));
  check(VecNorm(residual_.get(), NORM_2, &guess));
  scale = std::max({scale, size, guess});
  check(KSPSolve(ksp_.get(), rhs, x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  check(KSPGetConvergedReason(ksp_.get(), &reason));
  check(KSPGetIterationNumber(ksp_.get(), &iterations));
  if (reason < 0) {
    throw NumericalError(std::string("the linear solver did not converge for ") + what + ": " +
                         KSPConvergedReasons[reason] + " after " + std::to_string(iterations) +
                         " iterations");
  }
  require_solved(rhs, x, what, largest_residual * scale);
  return iterations;
}

/// Options can end the iteration early and call it converged (-ksp_rtol, -ksp_type preonly with a
/// weak PC, -ksp_norm_type none): what counts is how far the answer is from solving the system.
void ConstrainedSolver::require_solved(Vec rhs, Vec x, const char* what, double allowed) {
  PetscReal miss = 0;
  check(MatMult(shell_.get(), x, residual_.get()));
  check(VecAXPY(residual_.get(), -1, rhs));
  check(VecNorm(residual_.get(), NORM_2, &miss));
  if (miss <= allowed) return;
  char text[120];
  std::snprintf(text, sizeof text, "the linear solver left a residual of %.1e (allowed: %.1e) for ",
                miss, allowed);
  throw NumericalError(std::string(text) + what +
                       "; solver options (after --), if there are any, do not fit this scene");
}

ConstrainedSolver::Result ConstrainedSolver::solve(
    Mat a, Vec b, std::span<const DofValue> given, const MeanCondition* mean, Vec x, Vec reaction) {
  static const LogEvent event("StyletSolve");
  const LogScope scope(event);
  adopt(a, b);
  PetscInt begin = 0;
  PetscInt end = 0;
  check(VecGetOwnershipRange(b, &begin, &end));
  prescribed_.clear();
  for (const auto& [dof, value] : given) {
    if (dof >= begin && dof < end) prescribed_.push_back(dof - begin);
  }
  if (stale_) {
    factor_->set_up(a, prescribed_);
    stale_ = false;
  }

  // rhs = P (b - A g) with g the given values, zero elsewhere.
  check(VecSet(work_.get(), 0));
  PetscScalar* values = nullptr;
  check(VecGetArray(work_.get(), &values));
  for (const auto& [dof, value] : given) {
    if (dof >= begin && dof < end) values[dof - begin] = value;
  }
  check(VecRestoreArray(work_.get(), &values));
  check(MatMult(a_, work_.get(), rhs_.get()));
  check(VecAYPX(rhs_.get(), -1, b));
  project(rhs_.get());
  project(x);
  Result result;
  result.iterations = run(rhs_.get(), x, "the displacements", largest_rhs_);
  if (mean != nullptr) {
    check(VecSet(weights_.get(), 0));
    check(VecGetArray(weights_.get(), &values));
    for (const auto& [dof, weight] : mean->weights) {
      if (dof >= begin && dof < end) values[dof - begin] = weight;
    }
    check(VecRestoreArray(weights_.get(), &values));
    const double reached = dot(weights_.get(), work_.get()) + dot(weights_.get(), x);
    check(VecCopy(weights_.get(), unit_.get()));
    project(unit_.get());
    project(response_.get());
    double own_scale = 0;
    result.iterations += run(unit_.get(), response_.get(), "the tip condition", own_scale);
    const double compliance = dot(unit_.get(), response_.get());
    if (!(compliance > 0)) throw_all_held();
    result.lambda = (mean->value - reached) / compliance;
    check(VecAXPY(x, result.lambda, response_.get()));
  }
  if (result.iterations > worn_out * (mean != nullptr ? 2 : 1)) stale_ = true;
  check(VecAXPY(x, 1, work_.get()));

  check(MatMult(a_, x, work_.get()));
  check(VecAXPY(work_.get(), -1, b));
  if (mean != nullptr) check(VecAXPY(work_.get(), -result.lambda, weights_.get()));
  check(VecSet(reaction, 0));
  const PetscScalar* residual = nullptr;
  check(VecGetArrayRead(work_.get(), &residual));
  check(VecGetArray(reaction, &values));
  for (const PetscInt i : prescribed_) values[i] = residual[i];
  check(VecRestoreArray(reaction, &values));
  check(VecRestoreArrayRead(work_.get(), &residual));
  return result;
}

}  // namespace stylet
