// Rows of a track: what a Cholesky factor keeps of them, and products with it.
#include "stylet/base/index.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/solvers/cholesky.hpp"

#include <petscblaslapack.h>

#include <algorithm>

namespace stylet {

namespace {

constexpr double one = 1;
constexpr double zero = 0;
constexpr PetscBLASInt unit = 1;

}  // namespace

// As `load`: each rank its subtrees, then all of them the top.
void Cholesky::add_panel(std::span<const SparseRow> rows, std::size_t first, std::size_t n) {
  std::vector<int> dofs;
  for (const auto& row : rows.subspan(first, n)) {
    for (const auto& [dof, weight] : row) dofs.push_back(dof);
  }
  Panel panel{path_of(dofs), first, n, {}};
  Path& path = panel.path;
  std::erase_if(path.fronts, [&](int s) { return !is_here(s); });
  compact(path);
  std::vector<double>& w = panel.values;
  w.assign(at(path.size) * n, 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    for (const auto& [dof, weight] : rows[first + k]) {
      const Index column = column_[at(dof)];
      const int owner = owner_[at(front_of_[at(column)])];
      if (owner == rank_ || (owner == everyone && rank_ == 0)) {
        w[k * at(path.size) + at(place(column))] = weight;
      }
    }
  }
  std::vector<int> mine;
  std::vector<int> top;
  for (const int s : path.fronts) (owner_[at(s)] == everyone ? top : mine).push_back(s);
  const auto columns = static_cast<int>(n);
  forward(mine, w.data(), path.size, columns);
  if (!top.empty()) {
    std::vector<double> sums;
    const auto for_top = [&](auto&& each) {
      for (std::size_t k = 0; k < n; ++k) {
        for_columns(top, [&](Index i) { each(w[k * at(path.size) + at(place(i))]); });
      }
    };
    for_top([&](double value) { sums.push_back(value); });
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                  comm_);
    auto sum = sums.begin();
    for_top([&](double& value) { value = *sum++; });
    forward(top, w.data(), path.size, columns);
  }
  uncompact();
  panels_.push_back(std::move(panel));
}

// entries += rows' J columns, [column * n_rows + row]: of the fronts that both have, each counted by one rank.
void Cholesky::add_product(const Panel& rows,
                           const Panel& columns,
                           std::span<const double> signed_values,
                           double* entries,
                           Index n_rows) const {
  const auto rows_n = static_cast<PetscBLASInt>(rows.n);
  const auto columns_n = static_cast<PetscBLASInt>(columns.n);
  const auto rows_stride = static_cast<PetscBLASInt>(rows.path.size);
  const auto columns_stride = static_cast<PetscBLASInt>(columns.path.size);
  const auto stride = static_cast<PetscBLASInt>(n_rows);
  const double* a = rows.values.data();
  const double* b = signed_values.data();
  auto s = rows.path.fronts.begin();
  auto t = columns.path.fronts.begin();
  while (s != rows.path.fronts.end() && t != columns.path.fronts.end()) {
    const Index of_s = front(*s).n_columns;
    const Index of_t = front(*t).n_columns;
    if (*s == *t && (owner_[at(*s)] != everyone || rank_ == 0)) {
      const auto depth = static_cast<PetscBLASInt>(of_s);
      BLASgemm_("T", "N", &rows_n, &columns_n, &depth, &one, a, &rows_stride, b, &columns_stride,
                &one, entries, &stride);
    }
    const bool next_s = *s <= *t;
    const bool next_t = *t <= *s;
    if (next_s) {
      a += of_s;
      ++s;
    }
    if (next_t) {
      b += of_t;
      ++t;
    }
  }
}

std::vector<double> Cholesky::inverse_entries(std::span<const SparseRow> rows, std::size_t from) {
  static const LogEvent event("StyletColumns");
  const LogScope scope(event);
  constexpr std::size_t batch = 32;
  std::size_t kept = panels_.empty() ? 0 : panels_.back().first + panels_.back().n;
  while (kept < rows.size()) {
    const std::size_t to = kept < from ? from : rows.size();
    const std::size_t n = std::min(batch, to - kept);
    add_panel(rows, kept, n);
    kept += n;
  }
  std::vector<double> entries(rows.size() * (rows.size() - from), 0.0);
  for (const auto& columns : panels_) {
    if (columns.first < from) continue;
    std::vector<double> signed_values = columns.values;
    if (!signs_.empty()) {
      auto value = signed_values.begin();
      for (std::size_t k = 0; k < columns.n; ++k) {
        for_columns(columns.path.fronts, [&](Index i) { *value++ *= signs_[at(i)]; });
      }
    }
    double* const to = entries.data() + (columns.first - from) * rows.size();
    for (const auto& panel : panels_) {
      add_product(panel, columns, signed_values, to + panel.first, static_cast<Index>(rows.size()));
    }
  }
  if (size_of(comm_) > 1 && !entries.empty()) {
    MPI_Allreduce(MPI_IN_PLACE, entries.data(), static_cast<int>(entries.size()), MPI_DOUBLE,
                  MPI_SUM, comm_);
  }
  return entries;
}

std::vector<double> Cholesky::loaded_rows(std::size_t from) {
  const std::size_t n = panels_.empty() ? 0 : panels_.back().first + panels_.back().n;
  std::vector<double> values(n - from, 0.0);
  if (!loaded_ || values.empty()) return values;
  std::vector<double> z;
  for (const auto& panel : panels_) {
    if (panel.first < from) continue;
    z.clear();
    for_columns(panel.path.fronts, [&](Index i) { z.push_back(z_[at(i)]); });
    // What all ranks have counts once.
    if (rank_ != 0) {
      auto place = z.begin();
      for (const int s : panel.path.fronts) {
        const Index columns = front(s).n_columns;
        if (owner_[at(s)] == everyone) std::fill_n(place, columns, 0.0);
        place += columns;
      }
    }
    const auto size = static_cast<PetscBLASInt>(panel.path.size);
    const auto columns = static_cast<PetscBLASInt>(panel.n);
    if (size == 0) continue;
    BLASgemv_("T", &size, &columns, &one, panel.values.data(), &size, z.data(), &unit, &zero,
              values.data() + (panel.first - from), &unit);
  }
  if (size_of(comm_) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM,
                  comm_);
  }
  return values;
}

void Cholesky::respond_rows(std::span<const double> forces, bool add_loaded, Vec x) {
  static const LogEvent event("StyletSolve");
  const LogScope scope(event);
  if (add_loaded && loaded_) {
    w_ = z_;
  } else {
    std::ranges::fill(w_, 0.0);
  }
  std::vector<double> more;
  for (const auto& panel : panels_) {
    if (panel.first >= forces.size()) break;
    const auto of_panel =
        forces.subspan(panel.first, std::min(panel.n, forces.size() - panel.first));
    if (std::ranges::all_of(of_panel, [](double force) { return force == 0; })) continue;
    const auto size = static_cast<PetscBLASInt>(panel.path.size);
    const auto columns = static_cast<PetscBLASInt>(of_panel.size());
    if (size == 0) continue;
    more.resize(at(panel.path.size));
    BLASgemv_("N", &size, &columns, &one, panel.values.data(), &size, of_panel.data(), &unit, &zero,
              more.data(), &unit);
    auto next = more.begin();
    for_columns(panel.path.fronts, [&](Index i) {
      w_[at(i)] += signs_.empty() ? *next : signs_[at(i)] * *next;
      ++next;
    });
  }
  finish(x);
}

}  // namespace stylet
