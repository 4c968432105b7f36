// The whole tissue's solver for rows of a track.
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/solvers/whole_solver.hpp"

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
  std::vector<double> entries;
  const double unit[1] = {1};
  for (std::size_t i = from; i < rows.size(); ++i) {
    respond(rows.subspan(i, 1), unit, false, column_.get());
    const auto column = products(rows, column_.get());
    entries.insert(entries.end(), column.begin(), column.end());
  }
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
