#include "stylet/dynamics/state_products.hpp"

#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"

// PetscObjectStateGet, which is documented for all but declared here.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#include <petsc/private/petscimpl.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <utility>

namespace stylet {

double row_product(Mat matrix,
                   int row,
                   const std::vector<int>& columns,
                   const std::vector<double>& values) {
  PetscInt n = 0;
  const PetscInt* at = nullptr;
  const PetscScalar* entries = nullptr;
  check(MatGetRow(matrix, row, &n, &at, &entries));
  double sum = 0;
  for (PetscInt j = 0; j < n; ++j) {
    // Couplings kept for edge flips are zero and may lie outside.
    if (entries[j] == 0) continue;
    const auto found = std::ranges::lower_bound(columns, at[j]) - columns.begin();
    sum += entries[j] * values[static_cast<std::size_t>(found)];
  }
  check(MatRestoreRow(matrix, row, &n, &at, &entries));
  return sum;
}

StateVersion::StateVersion(const State& state) {
  const Vec vectors[2] = {state.u.get(), state.v.get()};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto object = reinterpret_cast<PetscObject>(vectors[i]);
    check(PetscObjectGetId(object, &id_[i]));
    check(PetscObjectStateGet(object, &change_[i]));
  }
}

StateProducts::StateProducts(const TissueOperator& tissue) {
  for (OwnedVec* vec : {&ku_, &kv_, &mv_, &next_ku_, &next_kv_, &next_mv_})
    *vec = tissue.make_vector();
}

void StateProducts::require(CellOperator& cells, const State& state) {
  if (of_ == StateVersion(state)) return;
  cells.stiffness_and_mass(state.u.get(), state.v.get(), ku_.get(), mv_.get());
  cells.stiffness(state.v.get(), kv_.get());
  of_ = StateVersion(state);
}

void StateProducts::compare(const State& state) {
  known_ = of_ == StateVersion(state);
}

void StateProducts::edited(const TissueOperator& tissue,
                           const State& state,
                           std::span<const int> rows,
                           std::span<const int> columns) {
  if (!std::exchange(known_, false)) {
    of_ = {};
    return;
  }
  const std::vector<int> dofs = dofs_of(columns);
  const Vec vectors[2] = {state.u.get(), state.v.get()};
  const auto fields = gather(vectors, dofs);
  {
    Entries ku(ku_.get());
    Entries kv(kv_.get());
    Entries mv(mv_.get());
    const bool lumped = tissue.lumped_mass() != nullptr;
    const Values mass(lumped ? tissue.lumped_mass() : state.u.get());
    const Values v(state.v.get());
    for (const int row : dofs_of(rows)) {
      if (!ku.owns(row)) continue;
      ku[row] = row_product(tissue.stiffness(), row, dofs, fields[0]);
      kv[row] = row_product(tissue.stiffness(), row, dofs, fields[1]);
      mv[row] = lumped ? mass[row] * v[row] : row_product(tissue.mass(), row, dofs, fields[1]);
    }
  }
  brought_to(state);
}

void StateProducts::swap() {
  std::swap(ku_, next_ku_);
  std::swap(kv_, next_kv_);
  std::swap(mv_, next_mv_);
}

}  // namespace stylet
