#include "stylet/dynamics/factor.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <string>

namespace stylet {

namespace {

// Right-hand sides of one solve: more gain nothing, and each is two vectors of all dofs.
constexpr int batch = 16;

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
// the arithmetic on small problems. Beyond that the memory of all ranks is needed: MUMPS.
Factor::Factor(MPI_Comm comm, PetscInt n_dofs) : comm_(comm) {
  constexpr PetscInt most_copied = 3000000;  // dofs on all ranks, about 7 GB
  check(PCCreate(comm, pc_.put()));
  PC factor = pc_.get();
  const bool replicated = size_of(comm) > 1 && n_dofs * size_of(comm) <= most_copied;
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

bool Factor::exact() {
  char* all = nullptr;
  check(PetscOptionsGetAll(nullptr, &all));
  const bool iterates = std::string(all).find("-ksp_") != std::string::npos;
  check(PetscFree(all));
  char type[64] = "";
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsGetString(nullptr, nullptr, "-pc_type", type, sizeof type, &given));
  const std::string name = type;
  const bool direct =
      given == PETSC_FALSE || name == PCCHOLESKY || name == PCLU || name == PCREDUNDANT;
  return direct && !iterates;
}

void Factor::set_up(Mat a, std::span<const PetscInt> eliminated) {
  static const LogEvent event("StyletFactor");
  const LogScope scope(event);
  PetscObjectId id = 0;
  check(PetscObjectGetId(reinterpret_cast<PetscObject>(a), &id));
  if (id != a_id_) {
    a_id_ = id;
    check(MatDuplicate(a, MAT_DO_NOT_COPY_VALUES, eliminated_.put()));
    check(MatSetOption(eliminated_.get(), MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
    check(MatSetOption(eliminated_.get(), MAT_SPD, PETSC_TRUE));
    check(MatSetOption(eliminated_.get(), MAT_SPD_ETERNAL, PETSC_TRUE));
    MatNullSpace rigid = nullptr;
    check(MatGetNearNullSpace(a, &rigid));
    check(MatSetNearNullSpace(eliminated_.get(), rigid));
    check(MatCreateVecs(a, work_.put(), nullptr));
  }
  check(MatCopy(a, eliminated_.get(), SAME_NONZERO_PATTERN));
  PetscInt first = 0;
  check(VecGetOwnershipRange(work_.get(), &first, nullptr));
  std::vector<PetscInt> rows;
  for (const PetscInt i : eliminated) rows.push_back(first + i);
  // The eliminated rows' diagonal has the size of the others, for the sake of conditioning.
  check(MatGetDiagonal(a, work_.get()));
  PetscScalar sum = 0;
  PetscInt n = 0;
  check(VecSum(work_.get(), &sum));
  check(VecGetSize(work_.get(), &n));
  check(MatZeroRowsColumns(eliminated_.get(), static_cast<PetscInt>(rows.size()), rows.data(),
                           sum / n, nullptr, nullptr));
  check(PCSetOperators(pc_.get(), eliminated_.get(), eliminated_.get()));
  if (n_set_ups_ == 0) {
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
  ++n_set_ups_;
}

void Factor::apply(Vec b, Vec x) const {
  check(PCApply(pc_.get(), b, x));
}

// The factor that this rank holds of the whole, or null.
PC Factor::own_copy() const {
  PetscBool replicated = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc_.get()), PCREDUNDANT, &replicated));
  if (replicated == PETSC_FALSE) return nullptr;
  KSP whole = nullptr;
  PC own = nullptr;
  check(PCRedundantGetKSP(pc_.get(), &whole));
  check(KSPGetPC(whole, &own));
  MPI_Comm comm = MPI_COMM_NULL;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(own), &comm));
  return size_of(comm) == 1 ? own : nullptr;
}

std::vector<double> Factor::inverse_entries(std::span<const int> rows,
                                            std::span<const int> columns) const {
  static const LogEvent event("StyletColumns");
  const LogScope scope(event);
  PetscInt begin = 0;
  PetscInt end = 0;
  PetscInt global = 0;
  check(VecGetOwnershipRange(work_.get(), &begin, &end));
  check(VecGetSize(work_.get(), &global));
  PC pc = pc_.get();
  MPI_Comm comm = comm_;
  std::size_t from = 0;
  std::size_t to = columns.size();
  if (PC alone = own_copy()) {
    // Every rank solves for some of the columns.
    pc = alone;
    comm = PETSC_COMM_SELF;
    begin = 0;
    end = global;
    const auto ranks = static_cast<std::size_t>(size_of(comm_));
    const auto rank = static_cast<std::size_t>(rank_of(comm_));
    from = columns.size() * rank / ranks;
    to = columns.size() * (rank + 1) / ranks;
  }
  std::vector<double> entries(rows.size() * columns.size(), 0.0);
  for (std::size_t first = from; first < to; first += batch) {
    const auto some = columns.subspan(first, std::min<std::size_t>(batch, to - first));
    const auto n = static_cast<PetscInt>(some.size());
    OwnedMat b;
    OwnedMat x;
    check(MatCreateDense(comm, end - begin, PETSC_DECIDE, global, n, nullptr, b.put()));
    check(MatCreateDense(comm, end - begin, PETSC_DECIDE, global, n, nullptr, x.put()));
    PetscScalar* values = nullptr;
    check(MatDenseGetArray(b.get(), &values));
    for (std::size_t k = 0; k < some.size(); ++k) {
      if (some[k] < begin || some[k] >= end) continue;
      values[k * static_cast<std::size_t>(end - begin) +
             static_cast<std::size_t>(some[k] - begin)] = 1;
    }
    check(MatDenseRestoreArray(b.get(), &values));
    check(MatAssemblyBegin(b.get(), MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(b.get(), MAT_FINAL_ASSEMBLY));
    check(PCMatApply(pc, b.get(), x.get()));
    const PetscScalar* solution = nullptr;
    check(MatDenseGetArrayRead(x.get(), &solution));
    for (std::size_t k = 0; k < some.size(); ++k) {
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (rows[i] < begin || rows[i] >= end) continue;
        entries[(first + k) * rows.size() + i] =
            solution[k * static_cast<std::size_t>(end - begin) +
                     static_cast<std::size_t>(rows[i] - begin)];
      }
    }
    check(MatDenseRestoreArrayRead(x.get(), &solution));
  }
  if (size_of(comm_) > 1 && !entries.empty()) {
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, entries.data(), static_cast<int>(entries.size()),
                            MPI_DOUBLE, MPI_SUM, comm_));
  }
  return entries;
}

}  // namespace stylet
