#include "stylet/solvers/near_field.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace stylet {

namespace {

constexpr double one = 1;
constexpr double minus_one = -1;
constexpr double zero = 0;

PetscBLASInt blas(std::size_t n) {
  return static_cast<PetscBLASInt>(n);
}

// Dense matrix n x n into the leading block of one of size m x m.
std::vector<double> enlarged(const std::vector<double>& old, std::size_t n, std::size_t m) {
  std::vector<double> matrix(m * m, 0.0);
  for (std::size_t j = 0; j < n; ++j) {
    std::copy_n(old.begin() + static_cast<std::ptrdiff_t>(j * n), n,
                matrix.begin() + static_cast<std::ptrdiff_t>(j * m));
  }
  return matrix;
}

std::vector<double> product(const std::vector<double>& symmetric, std::span<const double> x) {
  const PetscBLASInt n = blas(x.size());
  const PetscBLASInt unit = 1;
  std::vector<double> y(x.size());
  if (n > 0) {
    BLASgemv_("N", &n, &n, &one, symmetric.data(), &n, x.data(), &unit, &zero, y.data(), &unit);
  }
  return y;
}

}  // namespace

bool NearField::wants_factor() const {
  if (stale_) return true;
  // A factorisation costs about n^1.5, dense algebra the third power of the near dofs.
  constexpr std::size_t least = 60;
  constexpr std::size_t most = 400;
  const auto limit = static_cast<std::size_t>(2 * std::sqrt(static_cast<double>(n_dofs_)));
  return changed_.size() > std::clamp(limit, least, most);
}

void NearField::factor(Mat a,
                       std::span<const PrescribedDof> held,
                       const std::function<Mat()>& saddle) {
  held_.clear();
  held_here_.clear();
  if (!correction_) check(MatCreateVecs(a, correction_.put(), nullptr));
  PetscInt begin = 0;
  PetscInt end = 0;
  check(VecGetOwnershipRange(correction_.get(), &begin, &end));
  std::vector<PetscInt> owned;
  for (const auto& c : held) {
    held_.insert(c.dof);
    if (c.dof < begin || c.dof >= end) continue;
    owned.push_back(c.dof - begin);
    held_here_.push_back(c.dof);
  }
  std::ranges::sort(held_here_);
  factored_.take(a, owned);
  whole_.factor(factored_.matrix(), [&]() -> Mat {
    Mat form = saddle ? saddle() : nullptr;
    if (form == nullptr) return nullptr;
    saddle_.take(form, owned);
    return saddle_.matrix();
  });
  check(VecSet(correction_.get(), 1));
  {
    Entries b(correction_.get());
    for (const int dof : held_here_) b[dof] = 0;
  }
  whole_.prove(correction_.get());
  stale_ = false;
  leave_all();
}

void NearField::include(std::span<const int> coordinates) {
  std::vector<int> fresh;
  for (const int c : coordinates) {
    if (held_.contains(c) || index_.contains(c)) continue;
    index_[c] = coordinates_.size() + fresh.size();
    fresh.push_back(c);
  }
  if (!fresh.empty()) grow(fresh);
}

// Borders S by the block inverse: with G12, G22 the new columns of W, X = S G12 and
// T = (G22 - G21 X)^-1, the new S is [S + X T X', -X T; -T X', T].
void NearField::grow(std::span<const int> coordinates) {
  const std::size_t n = size();
  const std::size_t m = coordinates.size();
  const std::size_t all = n + m;
  for (const int c : coordinates) {
    const bool is_dof = c < n_dofs_;
    coordinates_.push_back(c);
    rows_.push_back(is_dof ? SparseRow() : track_->row(place_of(n_dofs_, c)));
    only_dofs_ = only_dofs_ && is_dof;
  }
  is_changed_.resize(all, false);
  std::vector<double> g = compliance(n);  // all x m
  static const LogEvent event("StyletCondense");
  const LogScope scope(event);
  const PetscBLASInt bn = blas(n);
  const PetscBLASInt bm = blas(m);
  const PetscBLASInt ball = blas(all);
  std::vector<double> x(n * m);
  std::vector<double> t(m * m);
  for (std::size_t j = 0; j < m; ++j) {
    for (std::size_t i = 0; i < m; ++i) t[j * m + i] = g[j * all + n + i];
  }
  if (n > 0) {
    BLASgemm_("N", "N", &bn, &bm, &bn, &one, s_.data(), &bn, g.data(), &ball, &zero, x.data(), &bn);
    BLASgemm_("T", "N", &bm, &bm, &bn, &minus_one, g.data(), &ball, x.data(), &bn, &one, t.data(),
              &bm);
  }
  PetscBLASInt info = 0;
  LAPACKpotrf_("L", &bm, t.data(), &bm, &info);
  if (info == 0) LAPACKpotri_("L", &bm, t.data(), &bm, &info);
  int failed = info != 0 ? 1 : 0;
  if (size_of(comm_) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, comm_);
  }
  if (failed != 0) {
    throw NumericalError(
        "the tissue near the needle cannot be condensed: its operator is singular or indefinite");
  }
  for (std::size_t j = 0; j < m; ++j) {
    for (std::size_t i = 0; i < j; ++i) t[j * m + i] = t[i * m + j];
  }
  // E of the old ones stays; new ones have none.
  std::vector<double> e = k_;
  for (std::size_t i = 0; i < e.size(); ++i) e[i] -= s_[i];
  s_ = enlarged(s_, n, all);
  if (n > 0) {
    double* corner = s_.data() + n * all;
    // -X T beside S, then S + X T X'.
    BLASgemm_("N", "N", &bn, &bm, &bm, &minus_one, x.data(), &bn, t.data(), &bm, &zero, corner,
              &ball);
    BLASgemm_("N", "T", &bn, &bn, &bm, &minus_one, corner, &ball, x.data(), &bn, &one, s_.data(),
              &ball);
  }
  for (std::size_t j = 0; j < m; ++j) {
    for (std::size_t i = 0; i < n; ++i) s_[i * all + n + j] = s_[(n + j) * all + i];
    for (std::size_t i = 0; i < m; ++i) s_[(n + j) * all + n + i] = t[j * m + i];
  }
  // The same bits above and below the diagonal.
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < j; ++i) s_[j * all + i] = s_[i * all + j];
  }
  k_ = enlarged(e, n, all);
  for (std::size_t i = 0; i < k_.size(); ++i) k_[i] += s_[i];
  l_.assign(all * all, 0.0);
  valid_ = 0;
  const auto values = loaded(n);
  y_near_.insert(y_near_.end(), values.begin(), values.end());
  s_y_ = product(s_, y_near_);
}

void NearField::changed(Mat a, std::span<const int> dofs) {
  include(dofs);
  std::vector<PetscInt> columns;
  for (const int dof : dofs) {
    if (!held_.contains(dof)) columns.push_back(dof);
  }
  const std::size_t m = columns.size();
  PetscInt begin = 0;
  PetscInt end = 0;
  check(MatGetOwnershipRange(a, &begin, &end));
  std::vector<PetscInt> rows;
  for (const PetscInt dof : columns) {
    if (dof >= begin && dof < end) rows.push_back(dof);
  }
  std::vector<double> now(rows.size() * m);
  std::vector<double> then(rows.size() * m);
  const auto n_rows = static_cast<PetscInt>(rows.size());
  const auto n_columns = static_cast<PetscInt>(m);
  check(MatGetValues(a, n_rows, rows.data(), n_columns, columns.data(), now.data()));
  check(MatGetValues(factored_.matrix(), n_rows, rows.data(), n_columns, columns.data(),
                     then.data()));
  std::vector<double> e(m * m, 0.0);
  for (std::size_t i = 0, r = 0; i < m && r < rows.size(); ++i) {
    if (columns[i] != rows[r]) continue;
    for (std::size_t j = 0; j < m; ++j) e[i * m + j] = now[r * m + j] - then[r * m + j];
    ++r;
  }
  if (size_of(comm_) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, e.data(), static_cast<int>(e.size()), MPI_DOUBLE, MPI_SUM, comm_);
  }
  const std::size_t n = size();
  for (std::size_t i = 0; i < m; ++i) {
    const std::size_t row = index_.at(columns[i]);
    valid_ = std::min(valid_, row);
    if (!is_changed_[row]) {
      is_changed_[row] = true;
      changed_.push_back(row);
    }
    for (std::size_t j = 0; j < m; ++j) {
      const std::size_t column = index_.at(columns[j]);
      k_[column * n + row] = s_[column * n + row] + 0.5 * (e[i * m + j] + e[j * m + i]);
    }
  }
}

void NearField::load(Vec b) {
  whole_.load(b);
  y_near_ = loaded(0);
  s_y_ = product(s_, y_near_);
}

void NearField::unload() {
  whole_.unload();
  y_near_.assign(size(), 0.0);
  s_y_.assign(size(), 0.0);
}

// Rows before `first` stay, and the part of later rows under them, but for rows whose mask changed.
void NearField::refactor_dense(const std::vector<bool>& masked,
                               const std::vector<double>& stiffness) {
  const std::size_t n = size();
  mask_.resize(n, false);
  stiffness_.resize(n, 0.0);
  std::vector<bool> anew(n, false);
  std::size_t first = valid_;
  for (std::size_t i = 0; i < n; ++i) {
    if (mask_[i] == masked[i] && stiffness_[i] == stiffness[i]) continue;
    anew[i] = mask_[i] != masked[i];
    first = std::min(first, i);
  }
  mask_ = masked;
  stiffness_ = stiffness;
  if (first == n) return;
  const auto entry = [&](std::size_t i, std::size_t j) {
    if (masked[i] || masked[j]) return i == j ? 1.0 : 0.0;
    return i == j ? k_[j * n + i] + stiffness[i] : k_[j * n + i];
  };
  const PetscBLASInt bn = blas(n);
  const PetscBLASInt done = blas(first);
  const PetscBLASInt rest = blas(n - first);
  for (std::size_t i = first; i < n && first > 0; ++i) {
    if (!anew[i]) continue;
    std::vector<double> row(first);
    for (std::size_t j = 0; j < first; ++j) row[j] = entry(i, j);
    const PetscBLASInt unit = 1;
    BLAStrsm_("L", "L", "N", "N", &done, &unit, &one, l_.data(), &bn, row.data(), &done);
    for (std::size_t j = 0; j < first; ++j) l_[j * n + i] = row[j];
  }
  for (std::size_t j = first; j < n; ++j) {
    for (std::size_t i = j; i < n; ++i) l_[j * n + i] = entry(i, j);
  }
  double* corner = l_.data() + first * n + first;
  if (first > 0) {
    BLASsyrk_("L", "N", &rest, &done, &minus_one, l_.data() + first, &bn, &one, corner, &bn);
  }
  PetscBLASInt info = 0;
  LAPACKpotrf_("L", &rest, corner, &bn, &info);
  if (info != 0) {
    throw NumericalError(
        "the operator near the needle is singular or indefinite: an element there is not valid");
  }
  valid_ = n;
}

void NearField::substitute(std::vector<double>& x) const {
  const PetscBLASInt n = blas(size());
  const PetscBLASInt unit = 1;
  BLAStrsm_("L", "L", "N", "N", &n, &unit, &one, l_.data(), &n, x.data(), &n);
  BLAStrsm_("L", "L", "T", "N", &n, &unit, &one, l_.data(), &n, x.data(), &n);
}

NearField::Solution NearField::solve(std::span<const double> extra, const Demand& demand) {
  if (size_of(comm_) == 1) return solve_here(extra, demand);
  const std::size_t n = size();
  Solution solution;
  std::optional<Failure> failure;
  try {
    solution = solve_here(extra, demand);
  } catch (const Error& error) {
    failure = Failure{error.code(), error.what()};
    valid_ = 0;
  }
  std::vector<double> packed(2 * n + 2, 0.0);
  packed[0] = solution.lambda;
  packed.back() = failure ? 1 : 0;
  std::ranges::copy(solution.x, packed.begin() + 1);
  std::ranges::copy(solution.reaction, packed.begin() + 1 + static_cast<std::ptrdiff_t>(n));
  MPI_Bcast(packed.data(), static_cast<int>(packed.size()), MPI_DOUBLE, 0, comm_);
  if (packed.back() != 0) {
    if (rank_of(comm_) != 0) failure.reset();
    agree(comm_, failure);
  }
  solution.lambda = packed[0];
  const auto middle = packed.begin() + 1 + static_cast<std::ptrdiff_t>(n);
  solution.x.assign(packed.begin() + 1, middle);
  solution.reaction.assign(middle, packed.end() - 1);
  return solution;
}

NearField::Solution NearField::solve_here(std::span<const double> extra, const Demand& demand) {
  static const LogEvent event("StyletCondense");
  const LogScope scope(event);
  const std::size_t n = size();
  Solution solution;
  solution.x.resize(n);
  solution.reaction.assign(n, 0.0);
  if (n == 0) return solution;
  std::vector<bool> masked(n, false);
  std::vector<double> prescribed(n, 0.0);
  bool homogeneous = true;
  for (const auto& g : demand.given) {
    masked[g.at] = true;
    prescribed[g.at] = g.value;
    homogeneous = homogeneous && g.value == 0;
  }
  std::vector<double> stiffness(n, 0.0);
  for (const auto& spring : demand.springs) stiffness[spring.at] = spring.stiffness;
  refactor_dense(masked, stiffness);
  std::vector<double> rhs(n);
  for (std::size_t i = 0; i < n; ++i) rhs[i] = s_y_[i] + extra[i];
  std::vector<double>& x = solution.x;
  x = rhs;
  for (const auto& spring : demand.springs) x[spring.at] += spring.force;
  if (!homogeneous) {
    const auto moved = product(k_, prescribed);
    for (std::size_t i = 0; i < n; ++i) x[i] -= moved[i];
  }
  for (const auto& g : demand.given) x[g.at] = g.value;
  substitute(x);
  std::vector<double> w;
  if (!demand.weights.empty()) {
    w.assign(n, 0.0);
    std::vector<double> response(n, 0.0);
    double reached = 0;
    for (const auto& [at, weight] : demand.weights) {
      w[at] = weight;
      reached += weight * x[at];
      if (!masked[at]) response[at] = weight;
    }
    substitute(response);
    double compliance = 0;
    for (const auto& [at, weight] : demand.weights) compliance += weight * response[at];
    if (std::isnan(compliance)) {
      throw NumericalError(
          "the factor of the tissue gives what is not a number; go on with --resume, and if that "
          "ends "
          "alike, the scene has numbers that are too large or too small");
    }
    if (!(compliance > 0)) throw_all_held();
    solution.lambda = (demand.value - reached) / (compliance + demand.rest);
    for (std::size_t i = 0; i < n; ++i) x[i] += solution.lambda * response[i];
  }
  for (const auto& g : demand.given) {
    double sum = -rhs[g.at] - (w.empty() ? 0 : solution.lambda * w[g.at]);
    for (std::size_t j = 0; j < n; ++j) sum += k_[g.at * n + j] * x[j];
    solution.reaction[g.at] = sum;
  }
  for (const auto& [at, force, k] : demand.springs) solution.reaction[at] = force - k * x[at];
  return solution;
}

std::vector<double> NearField::factored_forces(std::span<const double> x) const {
  return product(s_, x);
}

std::vector<double> NearField::changed_forces(std::span<const double> x) const {
  std::vector<double> forces(size(), 0.0);
  for (const std::size_t j : changed_) {
    const std::size_t column = j * size();
    for (const std::size_t i : changed_) {
      forces[i] += (k_[column + i] - s_[column + i]) * x[j];
    }
  }
  return forces;
}

}  // namespace stylet
