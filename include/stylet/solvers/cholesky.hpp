// Sparse Cholesky factor L L' = P A P' of a symmetric positive definite operator, all of it on every
// rank, with the two triangular solves apart and along paths. In space with averaged dilatation it is L J L',
// J = diag(+-1), of a saddle form that has fewer entries (signed_factor.hpp).
//
// Columns of L with the same pattern below are one dense front (CHOLMOD's supernode); its rows belong
// to itself and to its ancestors in the elimination tree. So what a force on one dof changes in the
// forward solve, and what a displacement of one dof needs of the backward solve, are the fronts from
// its own to the root: a small part of L for the dofs along a line through a plane. Source: T. Davis,
// Direct Methods for Sparse Linear Systems, SIAM 2006, sections 3.2 and 4.
//
// Rows of a track in space are means over many dofs, whose paths are most of L. So L^-1 P B^T is kept: B y
// and what forces on rows change in the forward solve are products with it, which reads a fraction of L,
// and B A^-1 B^T is its square.
//
// Ranks share whole solves by subtrees; the top of the tree, above those, is everyone's.
#pragma once

#include "stylet/petsc/owned.hpp"
#include "stylet/solvers/track_operator.hpp"

#include <cholmod.h>
#include <cstdint>
#include <span>
#include <vector>

namespace stylet {

class Cholesky {
 public:
  /// Collective. n_dofs: of all ranks.
  Cholesky(MPI_Comm comm, PetscInt n_dofs);
  Cholesky(const Cholesky&) = delete;
  Cholesky& operator=(const Cholesky&) = delete;
  ~Cholesky();

  /// Collective. saddle: null or a form of A with more unknowns, each rank's behind its dofs, with negative
  /// pivots; eliminating those leaves A (fem/split_stiffness.hpp). Throws NumericalError if A is singular or
  /// indefinite.
  void factor(Mat a, Mat saddle = nullptr);

  /// True if the factor is that of a saddle form.
  [[nodiscard]] bool is_signed() const { return !signs_.empty(); }
  /// Of L on this rank.
  [[nodiscard]] double bytes() const {
    return l_ == nullptr ? 0 : 8.0 * static_cast<double>(l_->xsize);
  }

  /// Collective. Entries of the inverse, on every rank: [column * rows.size() + row].
  [[nodiscard]] std::vector<double> inverse_entries(std::span<const int> rows,
                                                    std::span<const int> columns);
  /// Collective. Entries of B A^-1 B^T with these rows of B, columns from the `from`-th on, in the same
  /// order. The rows are those of the last call since `factor` or `leave_rows`, and new ones.
  [[nodiscard]] std::vector<double> inverse_entries(std::span<const SparseRow> rows,
                                                    std::size_t from);
  void leave_rows() { panels_.clear(); }

  /// Collective. The forward solve of A y = b.
  void load(Vec b);
  /// b = 0.
  void unload();
  /// Collective. y at these dofs, on every rank.
  [[nodiscard]] std::vector<double> loaded(std::span<const int> dofs);
  /// Collective. B y for the rows of `inverse_entries` from the `from`-th on, on every rank.
  [[nodiscard]] std::vector<double> loaded_rows(std::size_t from);
  /// Collective. x = A^-1 (forces on dofs), and y if it is asked for.
  void respond(std::span<const int> dofs, std::span<const double> forces, bool add_loaded, Vec x);
  /// The same for forces on the first rows of `inverse_entries`.
  void respond_rows(std::span<const double> forces, bool add_loaded, Vec x);

 private:
  using Index = SuiteSparse_long;
  /// Fronts, ascending, and where their columns stand in a dense array of `size` rows.
  struct Path {
    std::vector<int> fronts;
    Index size = 0;
  };
  /// Columns of L^-1 P B^T for some rows of B one after the other: zero but on the paths of the rows' dofs.
  struct Panel {
    Path path;  ///< fronts that are worked on here
    std::size_t first;
    std::size_t n;
    std::vector<double> values;  ///< path.size x n
  };
  struct Front {
    Index first;
    Index n_columns;
    Index n_rows;
    const Index* rows;
    const double* values;  ///< column-major, n_rows x n_columns
  };
  void place_unknowns(Mat a, Mat saddle);
  void read(Mat whole);
  void apply_signs(double* w, std::span<const int> fronts, Index size, std::size_t n) const;
  void share(Mat a);
  [[nodiscard]] Front front(int s) const;
  [[nodiscard]] int parent(int s) const;
  [[nodiscard]] bool is_here(int s) const {
    return owner_[static_cast<std::size_t>(s)] == everyone ||
           owner_[static_cast<std::size_t>(s)] == rank_;
  }
  [[nodiscard]] Path path_of(std::span<const int> dofs);
  void compact(Path& path);
  void uncompact();
  void add_panel(std::span<const SparseRow> rows, std::size_t first, std::size_t n);
  void add_product(const Panel& rows,
                   const Panel& columns,
                   std::span<const double> signed_values,
                   double* entries,
                   Index n_rows) const;
  void finish(Vec x);
  [[nodiscard]] Index place(Index row) const {
    if (!compacted_) return row;
    const auto s = static_cast<std::size_t>(front_of_[static_cast<std::size_t>(row)]);
    return place_[s] + row;
  }
  void forward(std::span<const int> fronts, double* w, Index size, int n);
  void backward(std::span<const int> fronts, double* w, Index size, int n);

  template <class Each>
  void for_columns(std::span<const int> fronts, Each&& each) const {
    for (const int s : fronts) {
      const Front f = front(s);
      for (Index i = f.first; i < f.first + f.n_columns; ++i) each(i);
    }
  }

  MPI_Comm comm_;
  int rank_;
  std::size_t n_dofs_;
  std::size_t n_ = 0;  ///< unknowns
  cholmod_common common_{};
  cholmod_factor* l_ = nullptr;
  PetscObjectId a_id_ = 0;
  OwnedMat whole_;              ///< on several ranks, all of A
  std::vector<int> dof_of_;     ///< of an unknown, or -1
  std::vector<double> signs_;   ///< of pivots, by column of L; none if all are positive
  std::vector<double> values_;  ///< of L, with signs
  std::vector<int> front_of_;   ///< of a column of L
  std::vector<Index> column_;   ///< of L, of a dof
  std::vector<Index> place_;    ///< of a front: its place in a dense array, less its first column
  bool compacted_ = false;
  std::vector<std::int64_t> stamp_;  ///< of a front: the last path that met it
  std::int64_t n_stamps_ = 0;
  std::vector<int> mine_;  ///< fronts of this rank's subtrees, ascending
  std::vector<int> top_;   ///< fronts of all ranks, ascending
  static constexpr int everyone = -1;
  std::vector<int> owner_;                        ///< of a front: the rank that works on it
  std::vector<Index> columns_here_;               ///< of mine_, on the first rank also of top_
  Owned<VecScatter, VecScatterDestroy> scatter_;  ///< from a vector of dofs to those
  OwnedVec local_;
  std::vector<Panel> panels_;
  std::vector<double> z_;  ///< L^-1 P b, by column of L
  bool loaded_ = false;
  std::vector<double> w_;      ///< work, by column of L
  std::vector<double> below_;  ///< work
};

}  // namespace stylet
