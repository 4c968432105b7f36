// The whole tissue's solver for rows of a track.
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/solvers/whole_solver.hpp"

#include <algorithm>

namespace stylet {

// B x
std::vector<double> WholeSolver::products(std::span<const SparseRow> rows, Vec x) {
  std::vector<int> behind;
  for (const auto& row : rows) {
    for (const auto& [dof, weight] : row) behind.push_back(dof);
  }
  const Vec vectors[1] = {x};
  const auto values = gather(vectors, behind)[0];
  auto next = values.begin();
  std::vector<double> sums;
  for (const auto& row : rows) {
    double& sum = sums.emplace_back(0.0);
    for (const auto& [dof, weight] : row) sum += weight * *next++;
  }
  return sums;
}

std::vector<double> WholeSolver::inverse_entries(std::span<const SparseRow> rows,
                                                 std::size_t from) {
  if (ours_) return cholesky_.inverse_entries(rows, from);
  kept_.resize(std::min(kept_.size(), from));
  std::vector<double> entries;
  answer_each(rows.subspan(kept_.size()), [&](Vec x) {
    OwnedVec& column = kept_.emplace_back();
    check(VecDuplicate(x, column.put()));
    check(VecCopy(x, column.get()));
    if (kept_.size() <= from) return;
    const auto sums = products(rows, x);
    entries.insert(entries.end(), sums.begin(), sums.end());
  });
  return entries;
}

std::vector<double> WholeSolver::loaded(std::span<const SparseRow> rows, std::size_t from) {
  if (ours_) return cholesky_.loaded_rows(from);
  if (!loaded_) return std::vector<double>(rows.size() - from, 0.0);
  return products(rows.subspan(from), y_.get());
}

void WholeSolver::respond(std::span<const SparseRow> rows,
                          std::span<const double> forces,
                          bool add_loaded,
                          Vec x) {
  if (!ours_) {
    if (add_loaded && loaded_) {
      check(VecCopy(y_.get(), x));
    } else {
      check(VecSet(x, 0));
    }
    std::vector<Vec> columns;
    for (const OwnedVec& column : std::span(kept_).first(forces.size())) {
      columns.push_back(column.get());
    }
    check(VecMAXPY(x, static_cast<PetscInt>(forces.size()), forces.data(), columns.data()));
    return;
  }
  start_rhs(add_loaded);
  {
    Entries rhs(rhs_.get());
    for (std::size_t i = 0; i < forces.size(); ++i) {
      if (forces[i] == 0) continue;
      for (const auto& [dof, weight] : rows[i]) {
        if (rhs.owns(dof)) rhs[dof] += weight * forces[i];
      }
    }
  }
  respond(Split{{}, forces, add_loaded, true}, x);
}

}  // namespace stylet
