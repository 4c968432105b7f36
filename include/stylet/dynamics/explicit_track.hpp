// A needle's track in explicit steps. The tissue's place at the end of a step does not feel the forces of its
// end, but the needle's place does, through what the mesh leaves out: C lambda = ubar - B u on the track, dense
// and without mass, so that the stable step is the tissue's.
#pragma once

#include "stylet/dynamics/row_forces.hpp"
#include "stylet/dynamics/time_integrator.hpp"
#include "stylet/solvers/near_field.hpp"

#include <functional>
#include <span>
#include <vector>

namespace stylet {

class ExplicitTrack {
 public:
  ExplicitTrack(MPI_Comm comm, int n_dofs)
      : n_dofs_(n_dofs), near_(comm, n_dofs, true), rows_(n_dofs) {}

  [[nodiscard]] bool is_followed() const { return rows_.has_track(); }
  void follow(const TrackOperator& track);
  void leave();
  /// Collective. u: of the state, at the start of the step.
  void watch(std::span<const int> coordinates, Vec u);
  /// Collective. The tissue at the end of the step, whatever the forces; moved: since it was told last.
  void place(Vec u, bool moved);
  /// Collective. Multiplier of the mean condition (N). h: of the step (s).
  double solve(const ConstraintSet& constraints, double h);
  [[nodiscard]] RowTrial row(int coordinate) const;
  /// B^T lambda of the last solution: calls with a dof and a force.
  void each_force(const std::function<void(int, double)>& force) const;
  void accept();
  /// J, of the last accepted step.
  [[nodiscard]] double energy() const { return rows_.energy(); }
  void archive(Archive& archive) { archive("rows", rows_); }

 private:
  int n_dofs_;
  NearField near_;
  RowForces rows_;
  std::vector<double> start_;  ///< of the near rows (m)
  std::size_t n_placed_ = 0;   ///< of them, in this step
  double h_ = 0;
  std::vector<double> extra_;
  NearField::Demand demand_;
  NearField::Solution solution_;
};

}  // namespace stylet
