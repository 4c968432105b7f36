#include "stylet/solvers/whole_solver.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/index.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string_view>

namespace stylet {

namespace {

// Of the true residual where an iterative solver is asked for: columns of the inverse make the near
// field, whose answers are good to 1e-9.
constexpr double tolerance = 1e-12;
constexpr int most_iterations = 2000;
// What options may make of it.
constexpr double largest_tolerance = 1e-8;

/// Of an option, if it is given.
std::optional<std::string> value_of(const char* option) {
  char text[100] = "";
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsGetString(nullptr, nullptr, option, text, sizeof text, &given));
  if (given != PETSC_TRUE) return std::nullopt;
  return text;
}

std::string type_of(KSP ksp) {
  KSPType type = nullptr;
  check(KSPGetType(ksp, &type));
  return type;
}

std::string type_of(PC pc) {
  PCType type = nullptr;
  check(PCGetType(pc, &type));
  return type;
}

bool is_direct(const std::string& pc) {
  return pc == PCCHOLESKY || pc == PCLU || pc == PCREDUNDANT || pc == PCSHELL;
}

// GAMG takes 1.1 times its estimate of the largest eigenvalue for a bound. Too low a bound makes its
// Chebyshev smoother indefinite, which ends CG: seen on 19,616 triangles around a needle.
void widen_smoother(PC pc) {
  constexpr const char* option = "-mg_levels_ksp_chebyshev_esteig";
  if (type_of(pc) != PCGAMG || value_of(option)) return;
  check(PetscOptionsSetValue(nullptr, option, "0,0.1,0,1.3"));
}

SolverKind kind_for(MPI_Comm comm, Mat a) {
  PetscInt n_dofs = 0;
  PetscInt dim = 0;
  MatInfo info;
  check(MatGetSize(a, &n_dofs, nullptr));
  check(MatGetBlockSize(a, &dim));
  check(MatGetInfo(a, MAT_GLOBAL_SUM, &info));
  const double row = info.nz_used / n_dofs;
  int kind = static_cast<int>(solver_for(factor_bytes(dim, n_dofs, row),
                                         assembled_factor_bytes(dim, n_dofs, row), size_of(comm),
                                         ranks_on_a_machine(), memory_for_solvers()));
  // The machine with the least room decides.
  MPI_Allreduce(MPI_IN_PLACE, &kind, 1, MPI_INT, MPI_MAX, comm);
  return static_cast<SolverKind>(kind);
}

}  // namespace

WholeSolver::WholeSolver(MPI_Comm comm, PetscInt n_dofs)
    : comm_(comm), n_dofs_(n_dofs), cholesky_(comm, n_dofs) {}

PetscErrorCode WholeSolver::set_up(PC shell) {
  return guard([&] {
    void* context = nullptr;
    check(PCShellGetContext(shell, &context));
    auto* self = static_cast<WholeSolver*>(context);
    const auto& saddle = *self->saddle_;
    self->cholesky_.factor(self->a_, saddle ? saddle() : nullptr);
  });
}

PetscErrorCode WholeSolver::apply(PC shell, Vec b, Vec x) {
  return guard([&] {
    void* context = nullptr;
    check(PCShellGetContext(shell, &context));
    auto* self = static_cast<WholeSolver*>(context);
    if (self->split_ != nullptr) {  // of b, which has been solved for in part
      const auto& [dofs, forces, add_loaded, of_rows] = *self->split_;
      if (of_rows) {
        self->cholesky_.respond_rows(forces, add_loaded, x);
      } else {
        self->cholesky_.respond(dofs, forces, add_loaded, x);
      }
    } else {
      self->cholesky_.load(b);
      self->cholesky_.respond({}, {}, true, x);
    }
  });
}

void WholeSolver::configure() {
  configured_ = true;
  check(KSPCreate(comm_, ksp_.put()));
  check(KSPSetType(ksp_.get(), KSPPREONLY));
  // The first guess is zero; an absolute tolerance would make small loads answerless.
  check(KSPSetTolerances(ksp_.get(), tolerance, 1e-300, PETSC_DEFAULT, most_iterations));
  PC pc = nullptr;
  check(KSPGetPC(ksp_.get(), &pc));
  const bool another_factor = value_of("-pc_factor_mat_solver_type").has_value();
  const SolverKind kind = kind_for(comm_, a_);
  if (kind == SolverKind::multigrid && !another_factor) {
    check(PCSetType(pc, PCGAMG));
  } else if (kind == SolverKind::factor_distributed || another_factor) {
    check(PCSetType(pc, PCCHOLESKY));
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  } else {
    check(PCSetType(pc, PCSHELL));
    check(PCShellSetName(pc, "CHOLMOD's factor, on every rank, solved along its elimination tree"));
    check(PCShellSetContext(pc, this));
    check(PCShellSetSetUp(pc, set_up));
    check(PCShellSetApply(pc, apply));
  }
  const std::string before = type_of(pc);
  // PETSc reads tolerances for iterative solvers only, so their type comes first.
  if (!is_direct(value_of("-pc_type").value_or(before))) check(KSPSetType(ksp_.get(), KSPCG));
  check(KSPSetOperators(ksp_.get(), a_, a_));
  check_options(KSPSetFromOptions(ksp_.get()));
  const std::string after = type_of(pc);
  const std::string ksp = type_of(ksp_.get());
  // The residual that stands in the near field's equations, not one that a PC has scaled.
  if (ksp == KSPCG && !value_of("-ksp_norm_type")) {
    check(KSPSetNormType(ksp_.get(), KSP_NORM_UNPRECONDITIONED));
  }
  widen_smoother(pc);
  PetscReal wanted = tolerance;
  check_options(PetscOptionsGetReal(nullptr, nullptr, "-ksp_rtol", &wanted, nullptr));
  if (!(wanted > 0 && wanted <= largest_tolerance)) {
    throw InputError(
        "PETSc option -ksp_rtol: allowed: above 0 and at most 1e-8, so that displacements can be "
        "relied on");
  }
  direct_ = ksp == KSPPREONLY;
  ours_ = direct_ && after == PCSHELL && before == PCSHELL;
  chosen_ = another_factor || value_of("-ksp_type") || value_of("-pc_type");
}

void WholeSolver::factor(Mat a, const std::function<Mat()>& saddle) {
  saddle_ = &saddle;
  loaded_ = false;
  leave_rows();
  const bool same_layout = y_ && a == a_;
  a_ = a;
  if (!same_layout) {
    for (OwnedVec* vec : {&y_, &rhs_, &column_, &work_})
      check(MatCreateVecs(a, vec->put(), nullptr));
  }
  if (configured_) {
    check(KSPSetOperators(ksp_.get(), a, a));
  } else {
    configure();
  }
  check_options(KSPSetUp(ksp_.get()));
  saddle_ = nullptr;
  PC pc = nullptr;
  PCFailedReason reason = PC_NOERROR;
  check(KSPGetPC(ksp_.get(), &pc));
  check(PCGetFailedReason(pc, &reason));
  if (reason != PC_NOERROR) {
    throw NumericalError(
        "the step's operator cannot be factored: it is singular or indefinite (is "
        "the tissue supported, and are all elements valid?)");
  }
}

// A saddle form's factor has no pivots to choose and no bound of its errors: it has to show what it can.
void WholeSolver::prove(Vec b) {
  if (!ours_ || !cholesky_.is_signed()) return;
  solve(b, column_.get());
  cholesky_.unload();
}

std::string WholeSolver::name() const {
  if (!configured_) return "none";
  PC pc = nullptr;
  check(KSPGetPC(ksp_.get(), &pc));
  std::string text = type_of(ksp_.get()) + ", " + type_of(pc);
  if (type_of(pc) == PCSHELL) {
    text = type_of(ksp_.get()) + ", cholmod on every rank";
  } else if (type_of(pc) == PCCHOLESKY || type_of(pc) == PCLU) {
    MatSolverType package = nullptr;
    check(PCFactorGetMatSolverType(pc, &package));
    if (package != nullptr) text += std::string(" (") + package + ")";
  }
  return text + (chosen_ ? ", by options" : ", by size");
}

void WholeSolver::require_converged() {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  check(KSPGetConvergedReason(ksp_.get(), &reason));
  check(KSPGetIterationNumber(ksp_.get(), &iterations));
  if (!direct_) iterations_ += iterations;
  if (reason >= 0) return;
  throw NumericalError(std::string("the linear solver did not converge for the whole tissue: ") +
                       KSPConvergedReasons[reason] + " after " + std::to_string(iterations) +
                       " iterations; take other solver options (after --), or none");
}

/// Options can end the iteration early and call it converged (-ksp_type preonly with a weak PC,
/// -ksp_norm_type none): what counts is how far the answer is from solving the system.
void WholeSolver::require_solved(Vec b, Vec x) {
  PetscReal miss = 0;
  PetscReal size = 0;
  check(VecNorm(b, NORM_2, &size));
  check(MatMult(a_, x, work_.get()));
  check(VecAXPY(work_.get(), -1, b));
  check(VecNorm(work_.get(), NORM_2, &miss));
  if (miss <= largest_tolerance * size) return;
  char text[200];
  std::snprintf(text, sizeof text,
                "the linear solver left a residual of %.1e (allowed: %.1e) for the whole tissue; "
                "solver options (after --), if there are any, do not fit this scene",
                miss, largest_tolerance * size);
  throw NumericalError(text);
}

void WholeSolver::solve(Vec b, Vec x) {
  static const LogEvent event("StyletSolve");
  const LogScope scope(event);
  check(KSPSolve(ksp_.get(), b, x));
  require_converged();
  require_solved(b, x);
}

/// Calls take(x) for the answer x to each of these forces, in their order.
void WholeSolver::answer_each(std::span<const SparseRow> forces,
                              const std::function<void(Vec)>& take) {
  static const LogEvent event("StyletColumns");
  const LogScope scope(event);
  if (!direct_) {
    for (const SparseRow& force : forces) {
      check(VecSet(rhs_.get(), 0));
      {
        Entries rhs(rhs_.get());
        for (const auto& [dof, value] : force) {
          if (rhs.owns(dof)) rhs[dof] += value;
        }
      }
      solve(rhs_.get(), column_.get());
      take(column_.get());
    }
    return;
  }
  constexpr std::size_t batch = 16;  // for which a factor is read once
  PetscInt n_local = 0;
  check(VecGetLocalSize(rhs_.get(), &n_local));
  for (std::size_t first = 0; first < forces.size(); first += batch) {
    const auto some = forces.subspan(first, std::min(batch, forces.size() - first));
    const auto n = static_cast<PetscInt>(some.size());
    OwnedMat loads;
    OwnedMat answers;
    check(MatCreateDense(comm_, n_local, PETSC_DECIDE, n_dofs_, n, nullptr, loads.put()));
    check(MatZeroEntries(loads.get()));
    PetscInt begin = 0;
    PetscInt end = 0;
    check(MatGetOwnershipRange(loads.get(), &begin, &end));
    for (PetscInt k = 0; k < n; ++k) {
      for (const auto& [dof, value] : some[at(k)]) {
        if (dof >= begin && dof < end) {
          check(MatSetValue(loads.get(), dof, k, value, INSERT_VALUES));
        }
      }
    }
    check(MatAssemblyBegin(loads.get(), MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(loads.get(), MAT_FINAL_ASSEMBLY));
    check(MatDuplicate(loads.get(), MAT_DO_NOT_COPY_VALUES, answers.put()));
    check(KSPMatSolve(ksp_.get(), loads.get(), answers.get()));
    require_converged();
    for (PetscInt k = 0; k < n; ++k) {
      Vec b = nullptr;
      Vec x = nullptr;
      check(MatDenseGetColumnVecRead(loads.get(), k, &b));
      check(MatDenseGetColumnVecRead(answers.get(), k, &x));
      require_solved(b, x);
      take(x);
      check(MatDenseRestoreColumnVecRead(answers.get(), k, &x));
      check(MatDenseRestoreColumnVecRead(loads.get(), k, &b));
    }
  }
}

std::vector<double> WholeSolver::inverse_entries(std::span<const int> rows,
                                                 std::span<const int> columns) {
  if (ours_) return cholesky_.inverse_entries(rows, columns);
  std::vector<SparseRow> units;
  for (const int dof : columns) units.push_back({{dof, 1.0}});
  std::vector<double> entries;
  answer_each(units, [&](Vec x) {
    const Vec vectors[1] = {x};
    const auto column = gather(vectors, rows)[0];
    entries.insert(entries.end(), column.begin(), column.end());
  });
  return entries;
}

void WholeSolver::load(Vec b) {
  loaded_ = true;
  b_ = b;
  if (ours_) {
    cholesky_.load(b);
  } else {
    solve(b, y_.get());
  }
}

void WholeSolver::unload() {
  loaded_ = false;
  if (ours_) cholesky_.unload();
}

std::vector<double> WholeSolver::loaded(std::span<const int> dofs) {
  if (ours_) return cholesky_.loaded(dofs);
  if (!loaded_) return std::vector<double>(dofs.size(), 0.0);
  const Vec vectors[1] = {y_.get()};
  return gather(vectors, dofs)[0];
}

void WholeSolver::respond(std::span<const int> dofs,
                          std::span<const double> forces,
                          bool add_loaded,
                          Vec x) {
  start_rhs(add_loaded);
  {
    Entries rhs(rhs_.get());
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      if (rhs.owns(dofs[i])) rhs[dofs[i]] += forces[i];
    }
  }
  respond(Split{dofs, forces, add_loaded, false}, x);
}

void WholeSolver::start_rhs(bool add_loaded) {
  if (add_loaded && loaded_ && ours_) {
    check(VecCopy(b_, rhs_.get()));
  } else {
    check(VecSet(rhs_.get(), 0));
  }
}

void WholeSolver::respond(const Split& split, Vec x) {
  if (!ours_) {
    solve(rhs_.get(), x);
    if (split.add_loaded && loaded_) check(VecAXPY(x, 1, y_.get()));
    return;
  }
  split_ = &split;
  try {
    check(KSPSolve(ksp_.get(), rhs_.get(), x));
  } catch (...) {
    split_ = nullptr;
    throw;
  }
  split_ = nullptr;
}

}  // namespace stylet
