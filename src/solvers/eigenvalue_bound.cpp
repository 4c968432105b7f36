#include "stylet/solvers/eigenvalue_bound.hpp"

#include "stylet/petsc/archive.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stylet {

EigenvalueBound::EigenvalueBound(const TissueOperator& tissue)
    : tissue_(tissue),
      even_(static_cast<std::size_t>((tissue.end_dof() - tissue.first_dof()) / tissue.dim())),
      weighted_(even_) {
  const auto masses = gather_all(tissue.lumped_mass());
  for (std::size_t i = 0; i < masses.size(); i += static_cast<std::size_t>(tissue.dim()))
    inverse_root_.push_back(1 / std::sqrt(masses[i]));
  make_weights();
  renew_all();
}

void EigenvalueBound::renew_all() {
  std::vector<int> owned(
      static_cast<std::size_t>((tissue_.end_dof() - tissue_.first_dof()) / tissue_.dim()));
  std::iota(owned.begin(), owned.end(), tissue_.first_dof() / tissue_.dim());
  renew(owned);
}

void EigenvalueBound::archive(Archive& archive) {
  OwnedVec x = tissue_.make_vector();
  {
    Entries values(x.get());
    for (int dof = tissue_.first_dof(); dof < tissue_.end_dof(); ++dof) {
      values[dof] = weights_[static_cast<std::size_t>(dof)];
    }
  }
  archive_field(archive, "weights", x.get());
  if (!archive.loads()) return;
  weights_ = gather_all(x.get());
  renew_all();
}

void EigenvalueBound::update(std::span<const int> changed, std::span<const int> rows) {
  std::vector<int> dofs;
  for (const int node : changed) dofs.push_back(tissue_.dim() * node);
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
    const auto at = static_cast<std::size_t>(node - tissue_.first_dof() / tissue_.dim());
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
  const auto width = static_cast<std::size_t>(tissue_.dim());
  OwnedVec x = tissue_.make_vector();
  check(VecSet(x.get(), 1));
  for (int sweep = 0; sweep <= sweeps; ++sweep) {
    weights_ = gather_all(x.get());
    if (sweep == sweeps) return;
    double largest[2] = {0, 0};
    Entries next(x.get());
    std::vector<double> product;
    for (int row = tissue_.first_dof(); row < tissue_.end_dof(); ++row) {
      double sum = 0;
      tissue_.along_row(row, [&](int column, double value) {
        const auto j = static_cast<std::size_t>(column);
        sum += std::abs(value) * inverse_root_[j / width] * weights_[j];
      });
      product.push_back(sum * inverse_root_[static_cast<std::size_t>(row) / width]);
      largest[0] = std::max(largest[0], product.back());
      largest[1] = std::max(largest[1], next[row]);
    }
    MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPI_DOUBLE, MPI_MAX, tissue_.comm());
    for (std::size_t i = 0; i < product.size(); ++i) {
      double& entry = next.data()[i];
      entry = 0.5 / largest[0] * product[i] + 0.5 / largest[1] * entry;
    }
  }
}

// The largest of a node's rows.
EigenvalueBound::Bounds EigenvalueBound::row_bounds(int node) const {
  Bounds largest{0, 0};
  const int dim = tissue_.dim();
  const auto width = static_cast<std::size_t>(dim);
  for (int row = dim * node; row < dim * node + dim; ++row) {
    double even = 0;
    double weighted = 0;
    tissue_.along_row(row, [&](int of, double value) {
      const auto column = static_cast<std::size_t>(of);
      const double entry = std::abs(value) * inverse_root_[column / width];
      even += entry;
      weighted += entry * weights_[column];
    });
    largest.even = std::max(largest.even, even);
    largest.weighted =
        std::max(largest.weighted, weighted / weights_[static_cast<std::size_t>(row)]);
  }
  const double own = inverse_root_[static_cast<std::size_t>(node)];
  return {largest.even * own, largest.weighted * own};
}

}  // namespace stylet
