// Move-only owners of PETSc objects. They lend the raw handle; PETSc's own functions do the rest.
#pragma once

#include <petscksp.h>
#include <petscts.h>

#include <utility>

namespace stylet {

template <class Raw, PetscErrorCode (*Destroy)(Raw*)>
class Owned {
 public:
  Owned() = default;
  explicit Owned(Raw raw) : raw_(raw) {}
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  Owned(Owned&& other) noexcept : raw_(std::exchange(other.raw_, nullptr)) {}
  Owned& operator=(Owned&& other) noexcept {
    std::swap(raw_, other.raw_);
    return *this;
  }
  ~Owned() {
    if (raw_ != nullptr) (void)Destroy(&raw_);
  }

  /// The handle, lent.
  [[nodiscard]] Raw get() const { return raw_; }
  /// Where a PETSc function may write a new handle; the old object is destroyed first.
  [[nodiscard]] Raw* put() {
    if (raw_ != nullptr) (void)Destroy(&raw_);
    raw_ = nullptr;
    return &raw_;
  }
  explicit operator bool() const { return raw_ != nullptr; }

 private:
  Raw raw_ = nullptr;
};

using OwnedVec = Owned<Vec, VecDestroy>;
using OwnedMat = Owned<Mat, MatDestroy>;
using OwnedKsp = Owned<KSP, KSPDestroy>;
using OwnedPc = Owned<PC, PCDestroy>;
using OwnedTs = Owned<TS, TSDestroy>;
using OwnedIs = Owned<IS, ISDestroy>;
using OwnedNullSpace = Owned<MatNullSpace, MatNullSpaceDestroy>;

}  // namespace stylet
