#include "stylet/solvers/cholesky.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/index.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/solvers/signed_factor.hpp"

#include <algorithm>
#include <limits>

namespace stylet {

namespace {

/// A SeqAIJ matrix's arrays, lent.
class Arrays {
 public:
  explicit Arrays(Mat a) : a_(a) {
    PetscBool done = PETSC_FALSE;
    check(MatGetRowIJ(a, 0, PETSC_FALSE, PETSC_FALSE, &n_rows, &first, &columns, &done));
    check(MatSeqAIJGetArrayRead(a, &values));
  }
  Arrays(const Arrays&) = delete;
  Arrays& operator=(const Arrays&) = delete;
  ~Arrays() {
    PetscBool done = PETSC_FALSE;
    (void)MatSeqAIJRestoreArrayRead(a_, &values);
    (void)MatRestoreRowIJ(a_, 0, PETSC_FALSE, PETSC_FALSE, &n_rows, &first, &columns, &done);
  }
  PetscInt n_rows = 0;
  const PetscInt* first = nullptr;
  const PetscInt* columns = nullptr;
  const PetscScalar* values = nullptr;

 private:
  Mat a_;
};

}  // namespace

Cholesky::Cholesky(MPI_Comm comm, PetscInt n_dofs)
    : comm_(comm), rank_(rank_of(comm)), n_dofs_(at(n_dofs)) {
  cholmod_l_start(&common_);
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.print = 0;
  common_.nmethods = 1;
}

Cholesky::~Cholesky() {
  cholmod_l_free_factor(&l_, &common_);
  cholmod_l_finish(&common_);
}

void Cholesky::factor(Mat a, Mat saddle) {
  static const LogEvent event("StyletFactor");
  const LogScope scope(event);
  loaded_ = false;
  PetscObjectId id = 0;
  Mat matrix = saddle != nullptr ? saddle : a;
  check(PetscObjectGetId(reinterpret_cast<PetscObject>(matrix), &id));
  const bool same = id == a_id_;
  panels_.clear();
  if (!same) {
    cholmod_l_free_factor(&l_, &common_);
    // Nested dissection has shorter paths and fewer entries, a quarter in large meshes of the plane, a third in
    // space; minimum degree is faster on small ones of the plane.
    constexpr std::size_t large = 10000;
    PetscInt dim = 0;
    check(MatGetBlockSize(a, &dim));
    common_.method[0].ordering = dim == 3 || n_dofs_ > large ? CHOLMOD_METIS : CHOLMOD_AMD;
    place_unknowns(a, saddle);
  }
  const int ranks = size_of(comm_);
  if (ranks == 1) {
    read(matrix);
  } else {
    Mat whole = whole_.get();
    check(MatCreateRedundantMatrix(matrix, ranks, MPI_COMM_NULL,
                                   same ? MAT_REUSE_MATRIX : MAT_INITIAL_MATRIX,
                                   same ? &whole : whole_.put()));
    read(whole_.get());
  }
  if (!same) share(a);
  a_id_ = id;
}

void Cholesky::place_unknowns(Mat a, Mat saddle) {
  PetscInt n = 0;
  const PetscInt* dofs = nullptr;
  const PetscInt* unknowns = nullptr;
  Mat matrix = saddle != nullptr ? saddle : a;
  check(MatGetSize(matrix, &n, nullptr));
  check(MatGetOwnershipRanges(a, &dofs));
  check(MatGetOwnershipRanges(matrix, &unknowns));
  n_ = at(n);
  signs_.assign(saddle != nullptr ? n_ : 0, 1.0);
  dof_of_.assign(n_, -1);
  for (int rank = 0; rank < size_of(comm_); ++rank) {
    for (PetscInt dof = dofs[rank]; dof < dofs[rank + 1]; ++dof) {
      dof_of_[at(unknowns[rank] + dof - dofs[rank])] = dof;
    }
  }
}

// Replaces the numbers of the factor, and its pattern if there is none.
void Cholesky::read(Mat whole) {
  const Arrays from(whole);
  const auto fail = [](bool indefinite) {
    if (!indefinite)
      throw Error(ExitCode::other, "the step's operator cannot be factored: out of memory");
    throw NumericalError(
        "the step's operator cannot be factored: it is singular or indefinite (is "
        "the tissue supported, and are all elements valid?)");
  };
  // A column of the upper half is a row of the lower one.
  std::size_t n_entries = 0;
  for (PetscInt i = 0; i < from.n_rows; ++i) {
    for (PetscInt j = from.first[i]; j < from.first[i + 1] && from.columns[j] <= i; ++j)
      ++n_entries;
  }
  cholmod_sparse* upper =
      cholmod_l_allocate_sparse(n_, n_, n_entries, 1, 1, 1, CHOLMOD_REAL, &common_);
  if (upper == nullptr) fail(false);
  auto* first = static_cast<Index*>(upper->p);
  auto* rows = static_cast<Index*>(upper->i);
  auto* values = static_cast<double*>(upper->x);
  Index n = 0;
  for (PetscInt i = 0; i < from.n_rows; ++i) {
    first[i] = n;
    for (PetscInt j = from.first[i]; j < from.first[i + 1] && from.columns[j] <= i; ++j, ++n) {
      rows[n] = from.columns[j];
      values[n] = from.values[j];
    }
  }
  first[n_] = n;
  if (l_ == nullptr) {
    static const LogEvent event("StyletOrder");
    const LogScope scope(event);
    l_ = cholmod_l_analyze(upper, &common_);
    for (std::size_t i = 0; l_ != nullptr && i < signs_.size(); ++i) {
      signs_[i] = dof_of_[at(static_cast<const Index*>(l_->Perm)[i])] < 0 ? -1 : 1;
    }
  }
  bool definite = true;
  if (l_ != nullptr && !signs_.empty()) {
    definite = factor_signed(*l_, *upper, signs_, values_);
  } else if (l_ != nullptr) {
    cholmod_l_factorize(upper, l_, &common_);
    definite = common_.status != CHOLMOD_NOT_POSDEF && l_->minor >= n_;
  }
  cholmod_l_free_sparse(&upper, &common_);
  if (l_ == nullptr || common_.status < 0) fail(false);
  if (!definite) fail(true);
  check(PetscLogFlops(common_.fl));
}

Cholesky::Front Cholesky::front(int s) const {
  const auto* first = static_cast<const Index*>(l_->super);
  const auto* first_row = static_cast<const Index*>(l_->pi);
  const auto* first_value = static_cast<const Index*>(l_->px);
  return {first[s], first[s + 1] - first[s], first_row[s + 1] - first_row[s],
          static_cast<const Index*>(l_->s) + first_row[s],
          (signs_.empty() ? static_cast<const double*>(l_->x) : values_.data()) + first_value[s]};
}

// -1 at a root.
int Cholesky::parent(int s) const {
  const Front f = front(s);
  return f.n_rows > f.n_columns ? front_of_[at(f.rows[f.n_columns])] : -1;
}

// Splits the heaviest subtrees until they can be dealt out evenly; what is split off goes to the top,
// which all ranks work on.
void Cholesky::share(Mat a) {
  const auto n_fronts = static_cast<int>(l_->nsuper);
  const auto* perm = static_cast<const Index*>(l_->Perm);
  column_.resize(n_dofs_);
  for (std::size_t i = 0; i < n_; ++i) {
    const int dof = dof_of_[at(perm[i])];
    if (dof >= 0) column_[at(dof)] = static_cast<Index>(i);
  }
  front_of_.resize(n_);
  for (int s = 0; s < n_fronts; ++s) {
    const Front f = front(s);
    std::fill_n(front_of_.begin() + f.first, f.n_columns, s);
  }
  place_.assign(at(n_fronts), 0);
  stamp_.assign(at(n_fronts), 0);
  n_stamps_ = 0;
  w_.resize(n_);
  z_.resize(n_);

  const auto ranks = at(size_of(comm_));
  std::vector<double> own(at(n_fronts));
  std::vector<double> subtree(at(n_fronts), 0.0);
  std::vector<std::vector<int>> children(at(n_fronts));
  std::vector<int> split;  // subtrees by their roots
  for (int s = 0; s < n_fronts; ++s) {
    const Front f = front(s);
    own[at(s)] = static_cast<double>(f.n_rows) * static_cast<double>(f.n_columns);
    subtree[at(s)] += own[at(s)];
    const int above = parent(s);
    if (above < 0) {
      split.push_back(s);
      continue;
    }
    subtree[at(above)] += subtree[at(s)];
    children[at(above)].push_back(s);
  }
  std::vector<std::pair<int, int>> best;  // root, rank
  double least = std::numeric_limits<double>::infinity();
  double top = 0;
  const std::size_t most_splits = ranks > 1 ? 32 * ranks : 1;
  for (std::size_t i = 0; i < most_splits; ++i) {
    std::ranges::sort(split, std::ranges::greater{}, [&](int s) { return subtree[at(s)]; });
    std::vector<double> load(ranks, 0.0);
    std::vector<std::pair<int, int>> dealt;
    for (const int s : split) {
      const auto rank = std::ranges::min_element(load) - load.begin();
      load[at(rank)] += subtree[at(s)];
      dealt.emplace_back(s, static_cast<int>(rank));
    }
    const double cost = top + std::ranges::max(load);
    if (cost < least) {
      least = cost;
      best = dealt;
    }
    if (split.empty()) break;
    const int heaviest = split.front();
    top += own[at(heaviest)];
    split.erase(split.begin());
    split.insert(split.end(), children[at(heaviest)].begin(), children[at(heaviest)].end());
  }
  owner_.assign(at(n_fronts), everyone);
  for (const auto& [root, rank] : best) owner_[at(root)] = rank;
  mine_.clear();
  top_.clear();
  for (int s = n_fronts - 1; s >= 0; --s) {
    const int above = parent(s);
    if (above >= 0 && owner_[at(above)] != everyone) owner_[at(s)] = owner_[at(above)];
    if (owner_[at(s)] == rank_) mine_.push_back(s);
    if (owner_[at(s)] == everyone) top_.push_back(s);
  }
  std::ranges::reverse(mine_);
  std::ranges::reverse(top_);
  if (ranks == 1) return;

  columns_here_.clear();
  std::vector<PetscInt> dofs;
  for (const auto* fronts : {&mine_, &top_}) {
    if (fronts == &top_ && rank_ != 0) continue;
    for (const int s : *fronts) {
      const Front f = front(s);
      for (Index i = f.first; i < f.first + f.n_columns; ++i) {
        const int dof = dof_of_[at(perm[i])];
        if (dof < 0) continue;
        columns_here_.push_back(i);
        dofs.push_back(dof);
      }
    }
  }
  OwnedIs here;
  const auto n_here = static_cast<PetscInt>(dofs.size());
  check(ISCreateGeneral(PETSC_COMM_SELF, n_here, dofs.data(), PETSC_COPY_VALUES, here.put()));
  check(VecCreateSeq(PETSC_COMM_SELF, n_here, local_.put()));
  OwnedVec any;
  check(MatCreateVecs(a, any.put(), nullptr));
  check(VecScatterCreate(any.get(), here.get(), local_.get(), nullptr, scatter_.put()));
}

// The fronts of these dofs and all above them.
Cholesky::Path Cholesky::path_of(std::span<const int> dofs) {
  Path path;
  ++n_stamps_;
  for (const int dof : dofs) {
    int s = front_of_[at(column_[at(dof)])];
    while (s >= 0 && stamp_[at(s)] != n_stamps_) {
      stamp_[at(s)] = n_stamps_;
      path.fronts.push_back(s);
      s = parent(s);
    }
  }
  std::ranges::sort(path.fronts);
  return path;
}

// From now on rows of these fronts stand one after the other.
void Cholesky::compact(Path& path) {
  path.size = 0;
  compacted_ = true;
  for (const int s : path.fronts) {
    const Front f = front(s);
    place_[at(s)] = path.size - f.first;
    path.size += f.n_columns;
  }
}

void Cholesky::uncompact() {
  compacted_ = false;
}

}  // namespace stylet
