// A x = b condensed to what is near the needle, exactly (static condensation).
//
// A0 is the operator when it was factored, with the supports eliminated; A = A0 + E on the dofs of
// nodes that an edit has touched since. Near are q = B x + C f: those dofs and those that the needle
// holds, whose rows of B are unit vectors without C, and rows of a track (track_operator.hpp). With the
// compliance W = B A0^-1 B^T + C and S = W^-1,
//
//   (S + E) q = S B y + f,   y = A0^-1 b,   x = y + A0^-1 B^T S (q - B y)
//
// f: forces on near coordinates, changes of b after `load`, what given ones and the mean condition
// need, and springs, which are solved for with q as a diagonal beside S + E. So a step costs one solve
// before its trials and one after them; a trial is dense algebra. The near field only grows, by solves
// for columns of W, until it is worth factoring anew. All ranks hold the dense matrices; what they decide
// on is what rank 0 makes of them.
#pragma once

#include "stylet/solvers/constraint_set.hpp"
#include "stylet/solvers/eliminated.hpp"
#include "stylet/solvers/whole_solver.hpp"

#include <functional>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace stylet {

class Entries;

class NearField {
 public:
  /// Collective.
  NearField(MPI_Comm comm, PetscInt n_dofs, bool still = false)
      : comm_(comm), n_dofs_(n_dofs), whole_(comm, n_dofs), still_(still) {}

  /// The rows behind the dofs, none for null; lent. Their compliance must be positive definite beside that of
  /// the tissue. Rows of another track are near no more, nor is anything else then.
  void follow(const TrackOperator* track);
  /// Collective. New factor with these dofs eliminated (of all ranks); nothing near. saddle: makes another form
  /// of A (cholesky.hpp), or null.
  void factor(Mat a, std::span<const PrescribedDof> held, const std::function<Mat()>& saddle = {});
  /// Of the whole tissue's solver.
  [[nodiscard]] const WholeSolver& whole() const { return whole_; }
  [[nodiscard]] int take_iterations() { return whole_.take_iterations(); }
  /// The next `begin` of its user must factor again.
  void forget() { stale_ = true; }
  /// True if there is no factor, or so many near dofs were `changed` that a new one pays.
  [[nodiscard]] bool wants_factor() const;

  [[nodiscard]] bool eliminated(int dof) const { return held_.contains(dof); }
  /// Near coordinates, dofs or rows (coordinate_of), in the order in which they came.
  [[nodiscard]] const std::vector<int>& coordinates() const { return coordinates_; }
  [[nodiscard]] bool is_near(int coordinate) const { return index_.contains(coordinate); }
  [[nodiscard]] std::size_t at(int coordinate) const { return index_.at(coordinate); }
  [[nodiscard]] bool is_row(std::size_t at) const { return coordinates_[at] >= n_dofs_; }

  /// Collective. Makes these near; eliminated dofs and what is near are passed over.
  void include(std::span<const int> coordinates);
  /// Collective. B times vectors at near coordinates, from the `from`-th on, on every rank.
  [[nodiscard]] std::vector<std::vector<double>> values(std::span<const Vec> vectors,
                                                        std::size_t from = 0) const;
  /// r -= B^T force, of one near coordinate.
  void subtract(std::size_t at, double force, Entries& r) const;
  /// Collective. Rows and columns of these dofs differ from the factor's, among each other only.
  void changed(Mat a, std::span<const int> dofs);
  /// Collective. b: zero at eliminated dofs; lent until the next load or unload.
  void load(Vec b);
  /// Collective. b = 0.
  void unload();
  /// Of a near field that was made `still`, of rows only: no force moves the tissue, which has these values at
  /// all near coordinates. W = C, and there is no factor.
  void stand_still(std::vector<double> values);

  struct Given {
    std::size_t at;
    double value;
  };
  /// A force that falls with its coordinate: force - stiffness q.
  struct Spring {
    std::size_t at;
    double force;
    double stiffness;
  };
  struct Demand {
    std::vector<Given> given;
    std::vector<Given> weights;   ///< of the mean condition, or empty
    double value = 0;             ///< of it
    double rest = 0;              ///< what its mean moves beyond them by a unit of lambda (m/N)
    std::vector<Spring> springs;  ///< not at given coordinates; each has one at most
  };
  struct Solution {
    std::vector<double> x;  ///< q
    /// f at given coordinates, less extra and lambda w; forces of springs; else zero.
    std::vector<double> reaction;
    double lambda = 0;
  };
  /// Collective: rank 0's numbers, since contacts hang on them. extra: forces on near coordinates.
  /// Throws NumericalError if the mean condition cannot be met.
  Solution solve(std::span<const double> extra, const Demand& demand);
  /// Collective. x = A0^-1 B^T forces, on the first near coordinates.
  void respond(std::span<const double> forces, Vec x);
  /// Collective. residual = A x - b
  using Balance = std::function<void(Vec x, Vec residual)>;
  /// Collective. The whole x of a solution, and what its forces leave of A x - b: nothing but at
  /// eliminated dofs; the last balance was of this x. largest: entry of b, without what was `extra`.
  /// If the factor left too much the solution is refined, and true returned: `load` has to be called
  /// anew. Throws NumericalError if that does not help.
  bool complete(const Balance& balance,
                double largest,
                std::span<const double> extra,
                const Demand& demand,
                Solution& solution,
                Vec x,
                Vec residual);

  /// S and E times q: forces on the near coordinates, if b was zero.
  [[nodiscard]] std::vector<double> factored_forces(std::span<const double> x) const;
  [[nodiscard]] std::vector<double> changed_forces(std::span<const double> x) const;

 private:
  void leave_all();
  void grow(std::span<const int> coordinates);
  [[nodiscard]] std::vector<double> compliance(std::size_t from);
  [[nodiscard]] std::vector<double> loaded(std::size_t from);
  void answer(std::span<const double> forces, bool add_loaded, Vec x);
  [[nodiscard]] double largest_free(Vec residual) const;
  void expand(std::span<const double> x_near, Vec x);
  [[nodiscard]] Solution solve_here(std::span<const double> extra, const Demand& demand);
  void refactor_dense(const std::vector<bool>& masked, const std::vector<double>& stiffness);
  void substitute(std::vector<double>& x) const;
  [[nodiscard]] std::size_t size() const { return coordinates_.size(); }

  MPI_Comm comm_;
  PetscInt n_dofs_;
  WholeSolver whole_;
  Eliminated factored_;  ///< A0
  Eliminated saddle_;    ///< its other form
  bool stale_ = true;
  bool still_ = false;
  std::unordered_set<int> held_;
  std::vector<int> held_here_;  ///< those of owned dofs, ascending
  const TrackOperator* track_ = nullptr;
  std::vector<int> coordinates_;
  std::vector<SparseRow> rows_;  ///< of B; empty for a dof
  /// Unless there are dofs only: the same without eliminated dofs, which do not move; unit vectors for dofs.
  std::vector<SparseRow> free_rows_;
  bool only_dofs_ = true;
  std::unordered_map<int, std::size_t> index_;
  std::vector<std::size_t> changed_;
  std::vector<bool> is_changed_;
  // Column-major, leading dimension size().
  std::vector<double> s_;
  std::vector<double> k_;  ///< S + E
  std::vector<double> l_;  ///< Cholesky factor of k_ with springs, given coordinates masked
  std::vector<bool> mask_;
  std::vector<double> stiffness_;  ///< of springs
  std::size_t valid_ = 0;          ///< leading rows of l_ that hold
  OwnedVec correction_;
  std::vector<double> y_near_;
  std::vector<double> s_y_;
};

}  // namespace stylet
