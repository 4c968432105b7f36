#include "stylet/solvers/mass_solver.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/log.hpp"

#include <string>

namespace stylet {

namespace {

constexpr double tolerance = 1e-14;  // of the residual scaled by the diagonal
constexpr int most_iterations = 200;

double dot(Vec x, Vec y) {
  PetscScalar value = 0;
  check(VecDot(x, y, &value));
  return value;
}

}  // namespace

MassSolver::MassSolver(MPI_Comm comm) : comm_(comm) {
  check(KSPCreate(comm, ksp_.put()));
  check(KSPSetType(ksp_.get(), KSPCG));
  check(KSPSetTolerances(ksp_.get(), tolerance, 1e-300, PETSC_DEFAULT, most_iterations));
  PC pc = nullptr;
  check(KSPGetPC(ksp_.get(), &pc));
  check(PCSetType(pc, PCJACOBI));
}

PetscErrorCode MassSolver::multiply(Mat shell, Vec x, Vec y) {
  return guard([&] {
    void* context = nullptr;
    check(MatShellGetContext(shell, &context));
    const auto* self = static_cast<MassSolver*>(context);
    // KSP's vectors are zero at the given dofs, so only the result needs projecting.
    check(MatMult(self->mass_, x, y));
    self->project(y);
  });
}

void MassSolver::project(Vec x) const {
  // On every rank, also where nothing is given: it invalidates the norm that PETSc remembers, and
  // ranks that remember different norms part ways in KSPSolve.
  PetscScalar* values = nullptr;
  check(VecGetArray(x, &values));
  for (const PetscInt i : given_) values[i] = 0;
  check(VecRestoreArray(x, &values));
}

void MassSolver::adopt(Mat mass, Vec like) {
  PetscObjectId id = 0;
  check(PetscObjectGetId(reinterpret_cast<PetscObject>(mass), &id));
  mass_ = mass;
  if (id != id_) {
    id_ = id;
    PetscInt local = 0;
    PetscInt global = 0;
    check(VecGetLocalSize(like, &local));
    check(VecGetSize(like, &global));
    check(MatCreateShell(comm_, local, local, global, global, this, shell_.put()));
    check(MatShellSetOperation(shell_.get(), MATOP_MULT, reinterpret_cast<void (*)()>(multiply)));
    check(MatSetOption(shell_.get(), MAT_SYMMETRIC, PETSC_TRUE));
    for (OwnedVec* vec : {&rhs_, &work_, &weights_, &response_, &unit_}) {
      check(VecDuplicate(like, vec->put()));
    }
  }
  check(KSPSetOperators(ksp_.get(), shell_.get(), mass));
}

void MassSolver::run(Vec rhs, Vec x) {
  PetscReal size = 0;
  check(VecNorm(rhs, NORM_2, &size));
  if (size == 0) {
    check(VecSet(x, 0));
    return;
  }
  check(KSPSolve(ksp_.get(), rhs, x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_.get(), &reason));
  if (reason > 0) return;
  throw NumericalError(std::string("accelerations cannot be found from forces: ") +
                       KSPConvergedReasons[reason] + "; are all elements valid?");
}

double MassSolver::solve(Mat mass,
                         Vec b,
                         std::span<const DofValue> given,
                         const MeanCondition* mean,
                         Vec x,
                         Vec reaction) {
  static const LogEvent event("StyletMass");
  const LogScope scope(event);
  adopt(mass, b);
  PetscInt begin = 0;
  PetscInt end = 0;
  check(VecGetOwnershipRange(b, &begin, &end));
  given_.clear();
  for (const auto& [dof, value] : given) {
    if (dof >= begin && dof < end) given_.push_back(dof - begin);
  }
  // rhs = P (b - M g) with g the given values, zero elsewhere.
  const auto put = [](Vec vector, std::span<const DofValue> entries) {
    check(VecSet(vector, 0));
    Entries values(vector);
    for (const auto& [dof, value] : entries) {
      if (values.owns(dof)) values[dof] = value;
    }
  };
  put(work_.get(), given);
  check(MatMult(mass, work_.get(), rhs_.get()));
  check(VecAYPX(rhs_.get(), -1, b));
  project(rhs_.get());
  run(rhs_.get(), x);
  double lambda = 0;
  if (mean != nullptr) {
    put(weights_.get(), mean->weights);
    const double reached = dot(weights_.get(), work_.get()) + dot(weights_.get(), x);
    check(VecCopy(weights_.get(), unit_.get()));
    project(unit_.get());
    run(unit_.get(), response_.get());
    const double compliance = dot(unit_.get(), response_.get());
    if (!(compliance > 0)) throw_all_held();
    lambda = (mean->value - reached) / compliance;
    check(VecAXPY(x, lambda, response_.get()));
  }
  check(VecAXPY(x, 1, work_.get()));

  check(MatMult(mass, x, work_.get()));
  check(VecAXPY(work_.get(), -1, b));
  if (mean != nullptr) check(VecAXPY(work_.get(), -lambda, weights_.get()));
  check(VecSet(reaction, 0));
  Entries forces(reaction);
  const Values residual(work_.get());
  for (const PetscInt i : given_) forces[begin + i] = residual[begin + i];
  return lambda;
}

}  // namespace stylet
