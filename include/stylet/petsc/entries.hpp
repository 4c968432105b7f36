// A vector's owned entries, by global index.
#pragma once

#include "stylet/petsc/check.hpp"

#include <petscmat.h>

namespace stylet {

class Entries {
 public:
  /// On every rank, also where nothing is written: it invalidates the norm that PETSc remembers,
  /// which must be so on all or none.
  explicit Entries(Vec vec) : vec_(vec) {
    check(VecGetOwnershipRange(vec, &begin_, &end_));
    check(VecGetArray(vec, &values_));
  }
  Entries(const Entries&) = delete;
  Entries& operator=(const Entries&) = delete;
  ~Entries() { (void)VecRestoreArray(vec_, &values_); }
  [[nodiscard]] bool owns(int i) const { return i >= begin_ && i < end_; }
  double& operator[](int i) { return values_[i - begin_]; }
  [[nodiscard]] double* data() { return values_; }

 private:
  Vec vec_;
  PetscInt begin_ = 0;
  PetscInt end_ = 0;
  PetscScalar* values_ = nullptr;
};

/// To read only.
class Values {
 public:
  explicit Values(Vec vec) : vec_(vec) {
    check(VecGetOwnershipRange(vec, &begin_, &end_));
    check(VecGetArrayRead(vec, &values_));
  }
  Values(const Values&) = delete;
  Values& operator=(const Values&) = delete;
  ~Values() { (void)VecRestoreArrayRead(vec_, &values_); }
  [[nodiscard]] bool owns(int i) const { return i >= begin_ && i < end_; }
  double operator[](int i) const { return values_[i - begin_]; }
  [[nodiscard]] const double* data() const { return values_; }

 private:
  Vec vec_;
  PetscInt begin_ = 0;
  PetscInt end_ = 0;
  const PetscScalar* values_ = nullptr;
};

/// Calls each(column, value) along an owned row of a matrix, by ascending columns, without zeros.
template <class Each>
void along_row(Mat matrix, int row, Each&& each) {
  PetscInt n = 0;
  const PetscInt* columns = nullptr;
  const PetscScalar* values = nullptr;
  check(MatGetRow(matrix, row, &n, &columns, &values));
  for (PetscInt j = 0; j < n; ++j) {
    if (values[j] != 0) each(columns[j], values[j]);
  }
  check(MatRestoreRow(matrix, row, &n, &columns, &values));
}

}  // namespace stylet
