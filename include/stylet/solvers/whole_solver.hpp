// The whole tissue's solver, A0 x = b: PETSc's KSP, as the near field needs it.
//
// By default the KSP is `preonly` and its PC our factor (cholesky.hpp): then columns of the inverse
// come along paths of the elimination tree, and a solve is split around the near field's trials.
// PETSc's options -ksp_*, -pc_* take any other solver: columns are then solves each. What only looks
// on (-ksp_view, -ksp_monitor, -ksp_converged_reason) leaves the default as it is, bit for bit.
#pragma once

#include "stylet/petsc/owned.hpp"
#include "stylet/solvers/cholesky.hpp"

#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace stylet {

enum class SolverKind {
  factor_everywhere,   ///< our factor, all of it on every rank
  factor_distributed,  ///< MUMPS
  multigrid            ///< conjugate gradients with GAMG
};

/// Bytes of our factor of an operator in 2 or 3 dimensions; entries_a_row: of the operator.
[[nodiscard]] double factor_bytes(int dim, double n_dofs, double entries_a_row);
/// Of the factor of the operator itself, where ours is of another form.
[[nodiscard]] double assembled_factor_bytes(int dim, double n_dofs, double entries_a_row);

/// By what our factor, and one of the assembled operator, take of the memory of a machine (bytes): at most half of
/// it for ours on every rank; else, on several ranks, a shared one of the latter, which while it is made takes at
/// most two thirds; else none.
[[nodiscard]] SolverKind solver_for(
    double factor, double assembled, int ranks, int ranks_of_machine, double machine_memory);
/// Of this machine, without swap space, or what a limit leaves of it (bytes).
[[nodiscard]] double memory_for_solvers();

class WholeSolver {
 public:
  /// Collective. n_dofs: of all ranks.
  WholeSolver(MPI_Comm comm, PetscInt n_dofs);
  WholeSolver(const WholeSolver&) = delete;
  WholeSolver& operator=(const WholeSolver&) = delete;
  ~WholeSolver() = default;

  /// Collective. The operator, lent until the next one; its pattern stays as long as its object does.
  /// saddle: makes another form of it (cholesky.hpp), or null, if our factor is to be made. Throws
  /// NumericalError if it is singular or indefinite.
  void factor(Mat a, const std::function<Mat()>& saddle = {});

  /// Collective. Throws NumericalError if the new factor is of another form than the operator and leaves much of b,
  /// which is zero at eliminated dofs.
  void prove(Vec b);

  /// Collective. Entries of the inverse, on every rank: [column * rows.size() + row].
  [[nodiscard]] std::vector<double> inverse_entries(std::span<const int> rows,
                                                    std::span<const int> columns);
  /// Collective. Entries of B A^-1 B^T with these rows of B, columns from the `from`-th on, in the same order.
  [[nodiscard]] std::vector<double> inverse_entries(std::span<const SparseRow> rows,
                                                    std::size_t from);
  /// No rows; before others than those of the last `inverse_entries` and new ones.
  void leave_rows() {
    cholesky_.leave_rows();
    kept_.clear();
  }

  /// Collective. y = A^-1 b, as far as `loaded` and `respond` need it. b is lent until the next load
  /// or unload.
  void load(Vec b);
  /// b = 0.
  void unload();
  /// Collective. y at these dofs, on every rank.
  [[nodiscard]] std::vector<double> loaded(std::span<const int> dofs);
  /// Collective. B y for rows from the `from`-th on; the rows are those of `inverse_entries`.
  [[nodiscard]] std::vector<double> loaded(std::span<const SparseRow> rows, std::size_t from);
  /// Collective. x = A^-1 (forces on dofs), and y if it is asked for.
  void respond(std::span<const int> dofs, std::span<const double> forces, bool add_loaded, Vec x);
  /// The same for forces on the first of the rows of `inverse_entries`.
  void respond(std::span<const SparseRow> rows,
               std::span<const double> forces,
               bool add_loaded,
               Vec x);

  /// Of KSP since the last call, 0 with a direct solver.
  [[nodiscard]] int take_iterations() { return std::exchange(iterations_, 0); }
  /// Its KSP and PC, and who chose them. Of the first `factor` on.
  [[nodiscard]] std::string name() const;

 private:
  struct Split {
    std::span<const int> dofs;  ///< none if of_rows
    std::span<const double> forces;
    bool add_loaded;
    bool of_rows;
  };
  static PetscErrorCode set_up(PC shell);
  static PetscErrorCode apply(PC shell, Vec b, Vec x);
  void configure();
  [[nodiscard]] static std::vector<double> products(std::span<const SparseRow> rows, Vec x);
  void answer_each(std::span<const SparseRow> forces, const std::function<void(Vec)>& take);
  void start_rhs(bool add_loaded);
  void respond(const Split& split, Vec x);
  void solve(Vec b, Vec x);
  void require_solved(Vec b, Vec x);
  void require_converged();

  MPI_Comm comm_;
  PetscInt n_dofs_;
  Mat a_ = nullptr;
  const std::function<Mat()>* saddle_ = nullptr;  ///< during `factor`
  OwnedKsp ksp_;
  Cholesky cholesky_;
  bool configured_ = false;
  bool ours_ = false;             ///< the KSP does nothing but apply our factor
  bool direct_ = false;           ///< no iterations
  bool chosen_ = false;           ///< by options
  const Split* split_ = nullptr;  ///< of the right-hand side that the KSP is solving for
  int iterations_ = 0;
  bool loaded_ = false;
  Vec b_ = nullptr;
  OwnedVec y_;  ///< unless ours
  OwnedVec rhs_;
  OwnedVec column_;  ///< of the inverse
  std::vector<OwnedVec>
      kept_;  ///< A^-1 B^T by rows of B, unless ours: a solve costs far more than a column's room
  OwnedVec work_;
};

}  // namespace stylet
