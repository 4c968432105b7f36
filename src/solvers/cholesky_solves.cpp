// Triangular solves with the fronts of a Cholesky factor.
#include "stylet/base/index.hpp"
#include "stylet/base/lanes.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/solvers/cholesky.hpp"

#include <petscblaslapack.h>

#include <algorithm>

namespace stylet {

namespace {

constexpr double one = 1;
constexpr double minus_one = -1;
constexpr double zero = 0;

/// Dense part of L: a triangle over a rectangle, column-major.
struct Trapezoid {
  const double* values;
  std::ptrdiff_t n_rows;
  std::ptrdiff_t n_columns;
};

// Two columns of L that come next: the streams are too short for the hardware to see ahead, and L of
// large meshes comes from memory.
STYLET_INLINE void fetch(const double* a, std::ptrdiff_t n_rows, std::ptrdiff_t ahead) {
  constexpr std::ptrdiff_t cache_line = 8;
  for (std::ptrdiff_t i = 0; i < 2 * n_rows; i += cache_line) __builtin_prefetch(a + ahead + i);
}
constexpr std::ptrdiff_t far = 1024;

// own = L1^-1 own, below = L2 own; two columns at a time, which halves the way to `below` and back.
// BLAS is no faster on large fronts, and slower on small ones.
STYLET_LANES void down(const Trapezoid& l, double* __restrict own, double* __restrict below) {
  const std::ptrdiff_t n = l.n_columns;
  const std::ptrdiff_t m = l.n_rows - n;
  std::fill_n(below, m, 0.0);
  std::ptrdiff_t j = 0;
  for (; j + 2 <= n; j += 2) {
    const double* const a = l.values + j * l.n_rows;
    const double* const b = a + l.n_rows;
    fetch(a, l.n_rows, far);
    const double x = own[j] / a[j];
    const double y = (own[j + 1] - a[j + 1] * x) / b[j + 1];
    own[j] = x;
    own[j + 1] = y;
    for (std::ptrdiff_t i = j + 2; i < n; ++i) own[i] -= a[i] * x + b[i] * y;
    for (std::ptrdiff_t i = 0; i < m; ++i) below[i] += a[n + i] * x + b[n + i] * y;
  }
  if (j == n) return;
  const double* const a = l.values + j * l.n_rows;
  own[j] /= a[j];
  for (std::ptrdiff_t i = 0; i < m; ++i) below[i] += a[n + i] * own[j];
}

// own = L1^-T (own - L2' below), in the same way.
STYLET_LANES void up(const Trapezoid& l, double* __restrict own, const double* __restrict below) {
  const std::ptrdiff_t n = l.n_columns;
  const std::ptrdiff_t m = l.n_rows - n;
  // The columns that follow a thousand doubles later stand so many back; fetched line by line, as the
  // present ones are read.
  const std::ptrdiff_t ahead = 2 * l.n_rows * (1 + far / (2 * l.n_rows));
  // Adds products of columns a and b with x.
  const auto add = [ahead](const double* a, const double* b, const double* x, std::ptrdiff_t size,
                           double& of_a, double& of_b) STYLET_INNER {
    Lanes sum_a{};
    Lanes sum_b{};
    std::ptrdiff_t i = 0;
    for (; i + 8 <= size; i += 8) {
      __builtin_prefetch(a + i - ahead);
      __builtin_prefetch(b + i - ahead);
      const Lanes low = load_lanes(x + i);
      sum_a += load_lanes(a + i) * low;
      sum_b += load_lanes(b + i) * low;
      const Lanes high = load_lanes(x + i + 4);
      sum_a += load_lanes(a + i + 4) * high;
      sum_b += load_lanes(b + i + 4) * high;
    }
    if (i < size) {
      __builtin_prefetch(a + i - ahead);
      __builtin_prefetch(b + i - ahead);
    }
    if (i + 4 <= size) {
      const Lanes low = load_lanes(x + i);
      sum_a += load_lanes(a + i) * low;
      sum_b += load_lanes(b + i) * low;
      i += 4;
    }
    of_a += sum_of(sum_a);
    of_b += sum_of(sum_b);
    for (; i < size; ++i) {
      of_a += a[i] * x[i];
      of_b += b[i] * x[i];
    }
  };
  std::ptrdiff_t j = n;
  if (n % 2 == 1) {
    --j;
    const double* const a = l.values + j * l.n_rows;
    double of_a = 0;
    double same = 0;
    add(a + n, a + n, below, m, of_a, same);
    own[j] = (own[j] - of_a) / a[j];
  }
  while (j > 0) {
    j -= 2;
    const double* const a = l.values + j * l.n_rows;
    const double* const b = a + l.n_rows;
    double of_a = 0;
    double of_b = 0;
    add(a + j + 2, b + j + 2, own + j + 2, n - j - 2, of_a, of_b);
    add(a + n, b + n, below, m, of_a, of_b);
    own[j + 1] = (own[j + 1] - of_b) / b[j + 1];
    own[j] = (own[j] - of_a - a[j + 1] * own[j + 1]) / a[j];
  }
}

}  // namespace

// w: n columns of `size` rows.
void Cholesky::forward(std::span<const int> fronts, double* w, Index size, int n) {
  const auto columns = static_cast<PetscBLASInt>(n);
  const auto stride = static_cast<PetscBLASInt>(size);
  for (const int s : fronts) {
    const Front f = front(s);
    double* const own = w + place(f.first);
    const Index m = f.n_rows - f.n_columns;
    const Index* const below = f.rows + f.n_columns;
    below_.resize(std::max(below_.size(), at(m * n)));
    if (n == 1) {
      down({f.values, f.n_rows, f.n_columns}, own, below_.data());
      if (compacted_) {
        for (Index i = 0; i < m; ++i) w[place(below[i])] -= below_[at(i)];
      } else {
        for (Index i = 0; i < m; ++i) w[below[i]] -= below_[at(i)];
      }
      continue;
    }
    const auto rows = static_cast<PetscBLASInt>(f.n_rows);
    const auto n_own = static_cast<PetscBLASInt>(f.n_columns);
    const auto n_below = static_cast<PetscBLASInt>(m);
    BLAStrsm_("L", "L", "N", "N", &n_own, &columns, &one, f.values, &rows, own, &stride);
    if (m == 0) continue;
    BLASgemm_("N", "N", &n_below, &columns, &n_own, &one, f.values + f.n_columns, &rows, own,
              &stride, &zero, below_.data(), &n_below);
    for (Index i = 0; i < m; ++i) {
      double* const to = w + place(below[i]);
      for (Index k = 0; k < n; ++k) to[k * size] -= below_[at(k * m + i)];
    }
  }
}

// Between the two.
void Cholesky::apply_signs(double* w,
                           std::span<const int> fronts,
                           Index size,
                           std::size_t n) const {
  if (signs_.empty()) return;
  for (std::size_t k = 0; k < n; ++k, w += size) {
    for_columns(fronts, [&](Index i) { w[place(i)] *= signs_[at(i)]; });
  }
}

void Cholesky::backward(std::span<const int> fronts, double* w, Index size, int n) {
  const auto columns = static_cast<PetscBLASInt>(n);
  const auto stride = static_cast<PetscBLASInt>(size);
  for (auto s = fronts.rbegin(); s != fronts.rend(); ++s) {
    const Front f = front(*s);
    double* const own = w + place(f.first);
    const Index m = f.n_rows - f.n_columns;
    const Index* const below = f.rows + f.n_columns;
    below_.resize(std::max(below_.size(), at(m * n)));
    if (n == 1) {
      if (compacted_) {
        for (Index i = 0; i < m; ++i) below_[at(i)] = w[place(below[i])];
      } else {
        for (Index i = 0; i < m; ++i) below_[at(i)] = w[below[i]];
      }
      up({f.values, f.n_rows, f.n_columns}, own, below_.data());
      continue;
    }
    for (Index i = 0; i < m; ++i) {
      const double* const from = w + place(below[i]);
      for (Index k = 0; k < n; ++k) below_[at(k * m + i)] = from[k * size];
    }
    const auto rows = static_cast<PetscBLASInt>(f.n_rows);
    const auto n_own = static_cast<PetscBLASInt>(f.n_columns);
    const auto n_below = static_cast<PetscBLASInt>(m);
    if (m > 0) {
      BLASgemm_("T", "N", &n_own, &columns, &n_below, &minus_one, f.values + f.n_columns, &rows,
                below_.data(), &n_below, &one, own, &stride);
    }
    BLAStrsm_("L", "L", "T", "N", &n_own, &columns, &one, f.values, &rows, own, &stride);
  }
}

std::vector<double> Cholesky::inverse_entries(std::span<const int> rows,
                                              std::span<const int> columns) {
  static const LogEvent event("StyletColumns");
  const LogScope scope(event);
  constexpr std::size_t batch = 32;
  const auto ranks = at(size_of(comm_));
  const auto rank = at(rank_);
  const std::size_t from = columns.size() * rank / ranks;
  const std::size_t to = columns.size() * (rank + 1) / ranks;
  std::vector<double> entries(rows.size() * columns.size(), 0.0);
  std::vector<int> all(rows.begin(), rows.end());
  all.insert(all.end(), columns.begin(), columns.end());
  Path path = path_of(all);
  compact(path);
  for (std::size_t first = from; first < to; first += batch) {
    const auto some = columns.subspan(first, std::min(batch, to - first));
    const auto n = static_cast<int>(some.size());
    std::vector<double> w(at(path.size * n), 0.0);
    for (std::size_t k = 0; k < some.size(); ++k) {
      w[k * at(path.size) + at(place(column_[at(some[k])]))] = 1;
    }
    forward(path_of(some).fronts, w.data(), path.size, n);
    apply_signs(w.data(), path.fronts, path.size, some.size());
    backward(path.fronts, w.data(), path.size, n);
    for (std::size_t k = 0; k < some.size(); ++k) {
      const double* const column = w.data() + k * at(path.size);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        entries[(first + k) * rows.size() + i] = column[place(column_[at(rows[i])])];
      }
    }
  }
  uncompact();
  if (ranks > 1 && !entries.empty()) {
    MPI_Allreduce(MPI_IN_PLACE, entries.data(), static_cast<int>(entries.size()), MPI_DOUBLE,
                  MPI_SUM, comm_);
  }
  return entries;
}

void Cholesky::load(Vec b) {
  static const LogEvent event("StyletForward");
  const LogScope scope(event);
  loaded_ = true;
  const auto size = static_cast<Index>(n_);
  if (size_of(comm_) == 1) {
    const Values values(b);
    if (!signs_.empty()) std::ranges::fill(z_, 0.0);
    for (std::size_t i = 0; i < n_dofs_; ++i) z_[at(column_[i])] = values.data()[i];
    forward(mine_, z_.data(), size, 1);
    apply_signs(z_.data(), mine_, size, 1);
    return;
  }
  check(VecScatterBegin(scatter_.get(), b, local_.get(), INSERT_VALUES, SCATTER_FORWARD));
  check(VecScatterEnd(scatter_.get(), b, local_.get(), INSERT_VALUES, SCATTER_FORWARD));
  std::ranges::fill(z_, 0.0);
  {
    const Values values(local_.get());
    for (std::size_t i = 0; i < columns_here_.size(); ++i) {
      z_[at(columns_here_[i])] = values.data()[i];
    }
  }
  forward(mine_, z_.data(), size, 1);
  apply_signs(z_.data(), mine_, size, 1);
  std::vector<double> sums;
  for_columns(top_, [&](Index i) { sums.push_back(z_[at(i)]); });
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                comm_);
  auto sum = sums.begin();
  for_columns(top_, [&](Index i) { z_[at(i)] = *sum++; });
  forward(top_, z_.data(), size, 1);
  apply_signs(z_.data(), top_, size, 1);
}

void Cholesky::unload() {
  loaded_ = false;
}

std::vector<double> Cholesky::loaded(std::span<const int> dofs) {
  std::vector<double> values(dofs.size(), 0.0);
  if (!loaded_ || dofs.empty()) return values;
  Path path = path_of(dofs);
  std::erase_if(path.fronts, [&](int s) { return !is_here(s); });
  compact(path);
  std::vector<double> w;
  w.reserve(at(path.size));
  for_columns(path.fronts, [&](Index i) { w.push_back(z_[at(i)]); });
  backward(path.fronts, w.data(), path.size, 1);
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    const Index column = column_[at(dofs[i])];
    const int owner = owner_[at(front_of_[at(column)])];
    if (owner != rank_ && (owner != everyone || rank_ != 0)) continue;
    values[i] = w[at(place(column))];
  }
  uncompact();
  if (size_of(comm_) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM,
                  comm_);
  }
  return values;
}

void Cholesky::respond(std::span<const int> dofs,
                       std::span<const double> forces,
                       bool add_loaded,
                       Vec x) {
  static const LogEvent event("StyletSolve");
  const LogScope scope(event);
  // What the forces add to the forward solve; all ranks alike.
  Path path = path_of(dofs);
  compact(path);
  std::vector<double> more(at(path.size), 0.0);
  for (std::size_t i = 0; i < dofs.size(); ++i) more[at(place(column_[at(dofs[i])]))] = forces[i];
  forward(path.fronts, more.data(), path.size, 1);
  apply_signs(more.data(), path.fronts, path.size, 1);
  uncompact();
  if (add_loaded && loaded_) {
    w_ = z_;
  } else {
    std::ranges::fill(w_, 0.0);
  }
  auto next = more.begin();
  for_columns(path.fronts, [&](Index i) { w_[at(i)] += *next++; });
  finish(x);
}

// x = P' L^-T w_
void Cholesky::finish(Vec x) {
  const auto size = static_cast<Index>(n_);
  backward(top_, w_.data(), size, 1);
  backward(mine_, w_.data(), size, 1);
  if (size_of(comm_) == 1) {
    Entries values(x);
    for (std::size_t i = 0; i < n_dofs_; ++i) values.data()[i] = w_[at(column_[i])];
    return;
  }
  {
    Entries values(local_.get());
    for (std::size_t i = 0; i < columns_here_.size(); ++i) {
      values.data()[i] = w_[at(columns_here_[i])];
    }
  }
  check(VecScatterBegin(scatter_.get(), local_.get(), x, INSERT_VALUES, SCATTER_REVERSE));
  check(VecScatterEnd(scatter_.get(), local_.get(), x, INSERT_VALUES, SCATTER_REVERSE));
}

}  // namespace stylet
