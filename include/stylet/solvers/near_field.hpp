// A x = b condensed to the dofs near the needle, exactly (static condensation).
//
// A0 is the operator when it was factored, with the supports eliminated; A = A0 + E on the near dofs
// D: those of nodes that an edit has touched since, and those that the needle holds. With G the
// block D x D of A0^-1 and S = G^-1,
//
//   (S + E) x_D = S y_D + f_D,   y = A0^-1 b,   x = y + A0^-1 I_D S (x_D - y_D)
//
// f_D: forces on near dofs, changes of b after `load`, and what prescribed dofs and the mean
// condition need. So a step costs one solve before its trials and one after them; a trial is dense
// algebra on D. D only grows, by solves for columns of G, until it is worth factoring anew. All
// ranks hold the dense matrices; what they decide on is what rank 0 makes of them.
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

class NearField {
 public:
  /// Collective.
  NearField(MPI_Comm comm, PetscInt n_dofs) : comm_(comm), n_dofs_(n_dofs), whole_(comm, n_dofs) {}

  /// Collective. New factor with these dofs eliminated (of all ranks); no near dofs.
  void factor(Mat a, std::span<const PrescribedDof> held);
  /// Of the whole tissue's solver.
  [[nodiscard]] const WholeSolver& whole() const { return whole_; }
  [[nodiscard]] int take_iterations() { return whole_.take_iterations(); }
  /// The next `begin` of its user must factor again.
  void forget() { stale_ = true; }
  /// True if there is no factor, or so many near dofs were `changed` that a new one pays.
  [[nodiscard]] bool wants_factor() const;

  [[nodiscard]] bool eliminated(int dof) const { return held_.contains(dof); }
  /// Near dofs in the order in which they came.
  [[nodiscard]] const std::vector<int>& dofs() const { return dofs_; }
  [[nodiscard]] bool is_near(int dof) const { return index_.contains(dof); }
  [[nodiscard]] std::size_t at(int dof) const { return index_.at(dof); }

  /// Collective. Makes these dofs near; eliminated ones and those that are near are passed over.
  void include(std::span<const int> dofs);
  /// Collective. Rows and columns of these dofs differ from the factor's, among each other only.
  void changed(Mat a, std::span<const int> dofs);
  /// Collective. b: zero at eliminated dofs; lent until the next load or unload.
  void load(Vec b);
  /// Collective. b = 0.
  void unload();

  struct Given {
    std::size_t at;
    double value;
  };
  struct Solution {
    std::vector<double> x;         ///< of the near dofs
    std::vector<double> reaction;  ///< A x - b - lambda w at given dofs, zero elsewhere
    double lambda = 0;
  };
  /// Collective: rank 0's numbers, since contacts hang on them. extra: added to b at the near dofs.
  /// weights: of near dofs, or empty; value: of their condition. Throws NumericalError if it cannot be
  /// met.
  Solution solve(std::span<const double> extra,
                 std::span<const Given> given,
                 std::span<const Given> weights,
                 double value);
  /// Collective. x = A0^-1 times forces on the first near dofs.
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
                std::span<const Given> given,
                std::span<const Given> weights,
                Solution& solution,
                Vec x,
                Vec residual);

  /// A0 and E of x at the near dofs, if b was zero.
  [[nodiscard]] std::vector<double> factored_forces(std::span<const double> x) const;
  [[nodiscard]] std::vector<double> changed_forces(std::span<const double> x) const;

 private:
  void grow(std::span<const int> dofs);
  [[nodiscard]] double largest_free(Vec residual) const;
  void expand(std::span<const double> x_near, Vec x);
  [[nodiscard]] Solution solve_here(std::span<const double> extra,
                                    std::span<const Given> given,
                                    std::span<const Given> weights,
                                    double value);
  void refactor_dense(const std::vector<bool>& masked);
  void substitute(std::vector<double>& x) const;
  [[nodiscard]] std::size_t size() const { return dofs_.size(); }

  MPI_Comm comm_;
  PetscInt n_dofs_;
  WholeSolver whole_;
  Eliminated factored_;  ///< A0
  bool stale_ = true;
  std::unordered_set<int> held_;
  std::vector<int> held_here_;  ///< those of owned dofs, ascending
  std::vector<int> dofs_;
  std::unordered_map<int, std::size_t> index_;
  std::vector<std::size_t> changed_;
  std::vector<bool> is_changed_;
  // Column-major, leading dimension size().
  std::vector<double> s_;
  std::vector<double> k_;  ///< S + E
  std::vector<double> l_;  ///< Cholesky factor of k_ with given dofs masked
  std::vector<bool> mask_;
  std::size_t valid_ = 0;  ///< leading rows of l_ that hold
  OwnedVec correction_;
  std::vector<double> y_near_;
  std::vector<double> s_y_;
};

}  // namespace stylet
