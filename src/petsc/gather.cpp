#include "stylet/petsc/gather.hpp"

#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

namespace stylet {

std::vector<std::vector<double>> gather(std::span<const Vec> vectors, std::span<const int> dofs) {
  const std::size_t n = dofs.size();
  if (n == 0) return std::vector<std::vector<double>>(vectors.size());
  static const LogEvent event("StyletGather");
  const LogScope scope(event);
  std::vector<double> packed(vectors.size() * n, 0.0);
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(vectors.front()));
  for (std::size_t k = 0; k < vectors.size(); ++k) {
    PetscInt begin = 0;
    PetscInt end = 0;
    const PetscScalar* values = nullptr;
    check(VecGetOwnershipRange(vectors[k], &begin, &end));
    check(VecGetArrayRead(vectors[k], &values));
    for (std::size_t i = 0; i < n; ++i) {
      if (dofs[i] >= begin && dofs[i] < end) packed[k * n + i] = values[dofs[i] - begin];
    }
    check(VecRestoreArrayRead(vectors[k], &values));
  }
  if (size_of(comm) > 1) {
    // One rank owns a value and the others add zero: the sum has the owner's bits.
    MPI_Allreduce(MPI_IN_PLACE, packed.data(), static_cast<int>(packed.size()), MPI_DOUBLE, MPI_SUM,
                  comm);
  }
  std::vector<std::vector<double>> result(vectors.size());
  for (std::size_t k = 0; k < vectors.size(); ++k) {
    const auto first = packed.begin() + static_cast<std::ptrdiff_t>(k * n);
    result[k].assign(first, first + static_cast<std::ptrdiff_t>(n));
  }
  return result;
}

std::vector<double> gather_all(Vec vector) {
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(vector));
  const PetscInt* ranges = nullptr;
  check(VecGetOwnershipRanges(vector, &ranges));
  const int n_ranks = size_of(comm);
  std::vector<int> counts;
  std::vector<int> starts;
  for (int r = 0; r < n_ranks; ++r) {
    counts.push_back(ranges[r + 1] - ranges[r]);
    starts.push_back(ranges[r]);
  }
  std::vector<double> all(static_cast<std::size_t>(ranges[n_ranks]));
  const PetscScalar* values = nullptr;
  check(VecGetArrayRead(vector, &values));
  MPI_Allgatherv(values, counts[static_cast<std::size_t>(rank_of(comm))], MPI_DOUBLE, all.data(),
                 counts.data(), starts.data(), MPI_DOUBLE, comm);
  check(VecRestoreArrayRead(vector, &values));
  return all;
}

void set_owned(Vec vector, int dof, double value) {
  PetscInt begin = 0;
  PetscInt end = 0;
  check(VecGetOwnershipRange(vector, &begin, &end));
  // On every rank: it invalidates the norm that PETSc remembers, which must be so on all or none.
  PetscScalar* values = nullptr;
  check(VecGetArray(vector, &values));
  if (dof >= begin && dof < end) values[dof - begin] = value;
  check(VecRestoreArray(vector, &values));
}

}  // namespace stylet
