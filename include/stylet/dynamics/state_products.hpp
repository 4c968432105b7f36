// K u, K v and M v of a state, kept from step to step by integrators that get them anyway.
#pragma once

#include "stylet/dynamics/state.hpp"
#include "stylet/fem/cell_operator.hpp"
#include "stylet/fem/tissue_operator.hpp"

#include <span>
#include <vector>

namespace stylet {

/// Row of an owned dof times a vector known at `columns`, ascending, which hold all of the row.
[[nodiscard]] double row_product(Mat matrix,
                                 int row,
                                 const std::vector<int>& columns,
                                 const std::vector<double>& values);

/// Which state of a State something was taken from: PETSc counts every change of a vector.
class StateVersion {
 public:
  StateVersion() = default;
  explicit StateVersion(const State& state);
  friend bool operator==(const StateVersion&, const StateVersion&) = default;

 private:
  PetscObjectId id_[2] = {0, 0};
  PetscObjectState change_[2] = {-1, -1};
};

class StateProducts {
 public:
  explicit StateProducts(const TissueOperator& tissue);

  [[nodiscard]] Vec ku() const { return ku_.get(); }
  [[nodiscard]] Vec kv() const { return kv_.get(); }
  [[nodiscard]] Vec mv() const { return mv_.get(); }

  /// Collective. Makes them anew unless they are those of this state.
  void require(CellOperator& cells, const State& state);
  /// They have been brought to this state.
  void brought_to(const State& state) { of_ = StateVersion(state); }
  void forget() { of_ = {}; }
  /// Forgets them if they are not those of this state: before an edit of it.
  void compare(const State& state);
  /// Collective, after an edit of the state they were of. rows: nodes whose rows changed, or whose
  /// products did; columns: nodes that they couple to; both ascending.
  void edited(const TissueOperator& tissue,
              const State& state,
              std::span<const int> rows,
              std::span<const int> columns);

  /// The same of the end of a step; `swap` makes them those of the state.
  [[nodiscard]] Vec next_ku() const { return next_ku_.get(); }
  [[nodiscard]] Vec next_kv() const { return next_kv_.get(); }
  [[nodiscard]] Vec next_mv() const { return next_mv_.get(); }
  void swap();

 private:
  StateVersion of_;
  bool known_ = false;  ///< of the state as it is between `compare` and `edited`
  OwnedVec ku_;
  OwnedVec kv_;
  OwnedVec mv_;
  OwnedVec next_ku_;
  OwnedVec next_kv_;
  OwnedVec next_mv_;
};

}  // namespace stylet
