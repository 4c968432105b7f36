#include "stylet/solvers/eigenvalue_bound.hpp"

#include "stylet/petsc/check.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stylet {

namespace {

void absolute(Mat matrix) {
  Mat parts[2] = {matrix, nullptr};
  PetscBool split = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(matrix), MATMPIAIJ, &split));
  if (split == PETSC_TRUE) check(MatMPIAIJGetSeqAIJ(matrix, &parts[0], &parts[1], nullptr));
  for (Mat part : parts) {
    if (part == nullptr) continue;
    MatInfo info;
    PetscScalar* values = nullptr;
    check(MatGetInfo(part, MAT_LOCAL, &info));
    check(MatSeqAIJGetArray(part, &values));
    const auto n = static_cast<std::size_t>(info.nz_used);
    for (double& value : std::span(values, n)) value = std::abs(value);
    check(MatSeqAIJRestoreArray(part, &values));
  }
}

}  // namespace

EigenvalueBound::EigenvalueBound(const TissueOperator& tissue)
    : tissue_(tissue),
      even_(static_cast<std::size_t>(tissue.end_dof() - tissue.first_dof()) / 2),
      weighted_(even_) {
  const auto masses = gather_all(tissue.lumped_mass());
  for (std::size_t i = 0; i < masses.size(); i += 2)
    inverse_root_.push_back(1 / std::sqrt(masses[i]));
  make_weights();
  std::vector<int> owned(static_cast<std::size_t>(tissue.end_dof() - tissue.first_dof()) / 2);
  std::iota(owned.begin(), owned.end(), tissue.first_dof() / 2);
  renew(owned);
}

void EigenvalueBound::update(std::span<const int> changed, std::span<const int> rows) {
  std::vector<int> dofs;
  for (const int node : changed) dofs.push_back(2 * node);
  const Vec vectors[1] = {tissue_.lumped_mass()};
  const auto masses = gather(vectors, dofs)[0];
  for (std::size_t i = 0; i < changed.size(); ++i) {
    inverse_root_[static_cast<std::size_t>(changed[i])] = 1 / std::sqrt(masses[i]);
  }
  renew(rows);
}

void EigenvalueBound::renew(std::span<const int> rows) {
  for (const int node : rows) {
    if (!tissue_.owns(node)) continue;
    const auto at = static_cast<std::size_t>(node - tissue_.first_dof() / 2);
    const Bounds bounds = row_bounds(node);
    even_.set(at, bounds.even);
    weighted_.set(at, bounds.weighted);
  }
  double largest[2] = {even_.largest(), weighted_.largest()};
  if (size_of(tissue_.comm()) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPI_DOUBLE, MPI_MAX, tissue_.comm());
  }
  bound_ = std::min(largest[0], largest[1]);
}

// Power iteration with |A|, which lowers the bound from sweep to sweep; half of the old x stays, so that
// no entry vanishes.
void EigenvalueBound::make_weights() {
  constexpr int sweeps = 20;
  OwnedMat size;
  check(MatDuplicate(tissue_.stiffness(), MAT_COPY_VALUES, size.put()));
  absolute(size.get());
  OwnedVec root = tissue_.make_vector();
  check(VecCopy(tissue_.lumped_mass(), root.get()));
  check(VecSqrtAbs(root.get()));
  check(VecReciprocal(root.get()));
  check(MatDiagonalScale(size.get(), root.get(), root.get()));
  OwnedVec x = tissue_.make_vector();
  OwnedVec product = tissue_.make_vector();
  check(VecSet(x.get(), 1));
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    check(MatMult(size.get(), x.get(), product.get()));
    PetscReal largest[2] = {0, 0};
    check(VecNorm(product.get(), NORM_INFINITY, &largest[0]));
    check(VecNorm(x.get(), NORM_INFINITY, &largest[1]));
    check(VecAXPBY(x.get(), 0.5 / largest[0], 0.5 / largest[1], product.get()));
  }
  weights_ = gather_all(x.get());
}

// The larger of a node's two rows.
EigenvalueBound::Bounds EigenvalueBound::row_bounds(int node) const {
  Bounds largest{0, 0};
  for (int row = 2 * node; row < 2 * node + 2; ++row) {
    PetscInt n = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(tissue_.stiffness(), row, &n, &columns, &values));
    double even = 0;
    double weighted = 0;
    for (PetscInt j = 0; j < n; ++j) {
      const auto column = static_cast<std::size_t>(columns[j]);
      const double entry = std::abs(values[j]) * inverse_root_[column / 2];
      even += entry;
      weighted += entry * weights_[column];
    }
    check(MatRestoreRow(tissue_.stiffness(), row, &n, &columns, &values));
    largest.even = std::max(largest.even, even);
    largest.weighted =
        std::max(largest.weighted, weighted / weights_[static_cast<std::size_t>(row)]);
  }
  const double own = inverse_root_[static_cast<std::size_t>(node)];
  return {largest.even * own, largest.weighted * own};
}

}  // namespace stylet
