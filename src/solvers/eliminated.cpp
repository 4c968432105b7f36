#include "stylet/solvers/eliminated.hpp"

#include "stylet/petsc/check.hpp"

#include <vector>

namespace stylet {

void Eliminated::take(Mat a, std::span<const PetscInt> dofs) {
  PetscObjectId id = 0;
  check(PetscObjectGetId(reinterpret_cast<PetscObject>(a), &id));
  if (id != a_id_) {
    a_id_ = id;
    check(MatDuplicate(a, MAT_DO_NOT_COPY_VALUES, matrix_.put()));
    check(MatSetOption(matrix_.get(), MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
    check(MatSetOption(matrix_.get(), MAT_SPD, PETSC_TRUE));
    check(MatSetOption(matrix_.get(), MAT_SPD_ETERNAL, PETSC_TRUE));
    MatNullSpace rigid = nullptr;
    check(MatGetNearNullSpace(a, &rigid));
    check(MatSetNearNullSpace(matrix_.get(), rigid));
    check(MatCreateVecs(a, diagonal_.put(), nullptr));
  }
  check(MatCopy(a, matrix_.get(), SAME_NONZERO_PATTERN));
  PetscInt first = 0;
  check(VecGetOwnershipRange(diagonal_.get(), &first, nullptr));
  std::vector<PetscInt> rows;
  for (const PetscInt i : dofs) rows.push_back(first + i);
  // The eliminated rows' diagonal has the size of the others, for the sake of conditioning; above zero, also where a
  // saddle form has negative ones.
  check(MatGetDiagonal(a, diagonal_.get()));
  check(VecAbs(diagonal_.get()));
  PetscScalar sum = 0;
  PetscInt n = 0;
  check(VecSum(diagonal_.get(), &sum));
  check(VecGetSize(diagonal_.get(), &n));
  check(MatZeroRowsColumns(matrix_.get(), static_cast<PetscInt>(rows.size()), rows.data(), sum / n,
                           nullptr, nullptr));
}

}  // namespace stylet
