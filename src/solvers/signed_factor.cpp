#include "stylet/solvers/signed_factor.hpp"

#include "stylet/base/index.hpp"
#include "stylet/petsc/owned.hpp"

#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>

namespace stylet {

namespace {

using Index = SuiteSparse_long;
constexpr double one = 1;

PetscBLASInt blas(Index n) {
  return static_cast<PetscBLASInt>(n);
}

/// Lower half of P A P^T by columns.
struct Lower {
  std::vector<Index> first;
  std::vector<Index> rows;
  std::vector<double> values;
};

Lower permuted(const cholmod_factor& pattern, const cholmod_sparse& upper) {
  const auto n = static_cast<Index>(pattern.n);
  const auto* perm = static_cast<const Index*>(pattern.Perm);
  const auto* first = static_cast<const Index*>(upper.p);
  const auto* rows = static_cast<const Index*>(upper.i);
  const auto* values = static_cast<const double*>(upper.x);
  std::vector<Index> place(at(n));
  for (Index i = 0; i < n; ++i) place[at(perm[i])] = i;
  const auto each = [&](auto&& take) {
    for (Index j = 0; j < n; ++j) {
      for (Index k = first[j]; k < first[j + 1]; ++k) {
        const auto [column, row] = std::minmax(place[at(j)], place[at(rows[k])]);
        take(column, row, values[k]);
      }
    }
  };
  Lower lower{std::vector<Index>(at(n) + 1, 0), {}, {}};
  each([&](Index column, Index, double) { ++lower.first[at(column) + 1]; });
  for (std::size_t j = 0; j < at(n); ++j) lower.first[j + 1] += lower.first[j];
  lower.rows.resize(at(lower.first.back()));
  lower.values.resize(lower.rows.size());
  std::vector<Index> next = lower.first;
  each([&](Index column, Index row, double value) {
    const std::size_t to = at(next[at(column)]++);
    lower.rows[to] = row;
    lower.values[to] = value;
  });
  return lower;
}

/// A front's numbers: a triangle over a rectangle, column-major.
struct Trapezoid {
  double* values;
  Index n_rows;
  Index n_columns;
};

// Rows of L times J, rows x columns.
void scaled(const double* rows,
            Index stride,
            Index n_rows,
            std::span<const double> signs,
            std::vector<double>& copy) {
  copy.resize(at(n_rows) * signs.size());
  double* to = copy.data();
  for (std::size_t j = 0; j < signs.size(); ++j, to += n_rows) {
    const double* const column = rows + static_cast<Index>(j) * stride;
    for (Index i = 0; i < n_rows; ++i) to[i] = signs[j] * column[i];
  }
}

/// C = beta C + alpha A B^T where a column has no rows above the diagonal; B: n_columns x depth, packed.
struct LowerProduct {
  const double* a;
  Index a_stride;
  const double* b;
  Index depth;
};

void multiply(const LowerProduct& p,
              double alpha,
              double beta,
              double* c,
              Index n_rows,
              Index n_columns,
              Index stride) {
  constexpr Index strip = 128;
  const PetscBLASInt k = blas(p.depth);
  const PetscBLASInt a_stride = blas(p.a_stride);
  const PetscBLASInt b_stride = blas(n_columns);
  const PetscBLASInt c_stride = blas(stride);
  for (Index j = 0; j < n_columns; j += strip) {
    const PetscBLASInt m = blas(n_rows - j);
    const PetscBLASInt n = blas(std::min(strip, n_columns - j));
    BLASgemm_("N", "T", &m, &n, &k, &alpha, p.a + j, &a_stride, p.b + j, &b_stride, &beta,
              c + j * stride + j, &c_stride);
  }
}

// Columns from .. to of a front, all rows below: halves, the left one's part taken off the right one.
bool eliminate(const Trapezoid& front,
               Index from,
               Index to,
               std::span<const double> signs,
               std::vector<double>& work) {
  constexpr Index few = 32;
  const Index n = front.n_rows;
  if (to - from > few) {
    const Index middle = from + (to - from) / 2;
    if (!eliminate(front, from, middle, signs, work)) return false;
    const double* const left = front.values + from * n + middle;
    scaled(left, n, to - middle, signs.subspan(at(from), at(middle - from)), work);
    multiply({left, n, work.data(), middle - from}, -1, 1, front.values + middle * n + middle,
             n - middle, to - middle, n);
    return eliminate(front, middle, to, signs, work);
  }
  for (Index j = from; j < to; ++j) {
    double* const column = front.values + j * n;
    const double pivot = column[j] * signs[at(j)];
    if (!(pivot > 0)) return false;
    column[j] = std::sqrt(pivot);
    const double scale = signs[at(j)] / column[j];
    for (Index i = j + 1; i < to; ++i) column[i] *= scale;
    for (Index k = j + 1; k < to; ++k) {
      double* const other = front.values + k * n;
      const double factor = signs[at(j)] * column[k];
      for (Index i = k; i < to; ++i) other[i] -= factor * column[i];
    }
  }
  if (to == n) return true;
  const PetscBLASInt width = blas(to - from);
  const PetscBLASInt below = blas(n - to);
  const PetscBLASInt stride = blas(n);
  BLAStrsm_("R", "L", "T", "N", &below, &width, &one, front.values + from * n + from, &stride,
            front.values + from * n + to, &stride);
  for (Index j = from; j < to; ++j) {
    if (signs[at(j)] > 0) continue;
    double* const column = front.values + j * n;
    for (Index i = to; i < n; ++i) column[i] = -column[i];
  }
  return true;
}

}  // namespace

bool factor_signed(const cholmod_factor& pattern,
                   const cholmod_sparse& upper,
                   std::span<const double> signs,
                   std::vector<double>& values) {
  const auto n_fronts = static_cast<Index>(pattern.nsuper);
  const auto* first_column = static_cast<const Index*>(pattern.super);
  const auto* first_row = static_cast<const Index*>(pattern.pi);
  const auto* first_value = static_cast<const Index*>(pattern.px);
  const auto* rows = static_cast<const Index*>(pattern.s);
  const Lower a = permuted(pattern, upper);
  values.assign(pattern.xsize, 0.0);
  std::vector<Index> front_of(pattern.n);
  for (Index s = 0; s < n_fronts; ++s) {
    std::fill(front_of.begin() + first_column[s], front_of.begin() + first_column[s + 1], s);
  }
  // Fronts that wait for the one that their next rows belong to.
  std::vector<Index> head(at(n_fronts), -1);
  std::vector<Index> next(at(n_fronts), -1);
  std::vector<Index> done(at(n_fronts), 0);  // rows
  const auto wait = [&](Index d) {
    if (first_row[d] + done[at(d)] == first_row[d + 1]) return;
    const auto s = at(front_of[at(rows[first_row[d] + done[at(d)]])]);
    next[at(d)] = head[s];
    head[s] = d;
  };
  std::vector<Index> place(pattern.n);  // of a row, in the front
  std::vector<double> work;
  std::vector<double> update;
  for (Index s = 0; s < n_fronts; ++s) {
    const Index begin = first_column[s];
    const Index end = first_column[s + 1];
    const Trapezoid front{values.data() + first_value[s], first_row[s + 1] - first_row[s],
                          end - begin};
    for (Index i = 0; i < front.n_rows; ++i) place[at(rows[first_row[s] + i])] = i;
    for (Index j = begin; j < end; ++j) {
      double* const column = front.values + (j - begin) * front.n_rows;
      for (Index k = a.first[at(j)]; k < a.first[at(j) + 1]; ++k) {
        column[place[at(a.rows[at(k)])]] += a.values[at(k)];
      }
    }
    for (Index d = head[at(s)], after = -1; d >= 0; d = after) {
      after = next[at(d)];
      const Index n_rows = first_row[d + 1] - first_row[d];
      const Index n_columns = first_column[d + 1] - first_column[d];
      const Index* const of_d = rows + first_row[d] + done[at(d)];
      const Index left = n_rows - done[at(d)];
      Index own = 0;
      while (own < left && of_d[own] < end) ++own;
      const double* const from = values.data() + first_value[d] + done[at(d)];
      scaled(from, n_rows, own, signs.subspan(at(first_column[d]), at(n_columns)), work);
      update.resize(at(left * own));
      multiply({from, n_rows, work.data(), n_columns}, 1, 0, update.data(), left, own, left);
      for (Index j = 0; j < own; ++j) {
        double* const column = front.values + place[at(of_d[j])] * front.n_rows;
        const double* const of_j = update.data() + j * left;
        for (Index i = j; i < left; ++i) column[place[at(of_d[i])]] -= of_j[i];
      }
      done[at(d)] += own;
      wait(d);
    }
    if (!eliminate(front, 0, end - begin, signs.subspan(at(begin), at(end - begin)), work)) {
      return false;
    }
    done[at(s)] = front.n_columns;
    wait(s);
  }
  return true;
}

}  // namespace stylet
