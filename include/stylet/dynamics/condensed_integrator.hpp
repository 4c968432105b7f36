// What implicit integrators share: trials are dense algebra on the dofs near the needle
// (near_field.hpp), and one solve of the whole tissue ends the step.
#pragma once

#include "stylet/dynamics/row_forces.hpp"
#include "stylet/dynamics/state_products.hpp"
#include "stylet/dynamics/time_integrator.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/solvers/near_field.hpp"

#include <limits>
#include <span>
#include <string>
#include <vector>

namespace stylet {

class CondensedIntegrator : public TimeIntegrator {
 public:
  [[nodiscard]] double stable_step() const override {
    return std::numeric_limits<double>::infinity();
  }
  void touched(const Mesh& mesh, std::span<const int> cells) override;
  void renewed(const Mesh& mesh) override;
  [[nodiscard]] bool decides_by_velocity() const override { return false; }
  [[nodiscard]] StoredEnergy energy(const State& state) override;
  [[nodiscard]] std::string solver() const override { return near_.whole().name(); }
  void follow(const TrackOperator& track) override;
  void leave_track() override;

 protected:
  /// The tissue is lent.
  CondensedIntegrator(TissueOperator& tissue, const Mesh& mesh);

  /// Dofs that the constraints hold, push, damp or weigh.
  [[nodiscard]] static std::vector<int> dofs_of(const ConstraintSet& constraints);
  /// extra_ = change and the constraints' forces; change: of near dofs.
  void push(const ConstraintSet& constraints, std::span<const double> change);
  /// Springs of the near field that stand for dashpots: v1 = start + rate q of the i-th near dof; of a row
  /// the rate is that of its mean velocity.
  void damp(const ConstraintSet& constraints, double rate, const std::vector<double>& start);
  /// Takes what was added to b at near dofs from a residual.
  void take_extra(Vec residual, std::span<const double> extra) const;
  /// Displacement, velocity and reaction of the trial at near dofs; `u_of`, `v_of`: of the i-th.
  template <class Displacement, class Velocity>
  Trial near_trial(Displacement&& u_of, Velocity&& v_of);
  /// reaction_ = residual at held dofs, what the solution says at given ones, zero elsewhere.
  void collect_reactions(Vec residual);

  TissueOperator& tissue_;
  CellOperator cells_;
  NearField near_;
  RowForces rows_;
  StoredEnergy stored_;
  StateVersion stored_of_;
  State* state_ = nullptr;
  Vec load_ = nullptr;
  double h_ = 0;
  std::vector<PrescribedDof> held_;
  std::vector<int> edited_;    ///< nodes whose rows changed since the last trial; ascending
  std::vector<double> extra_;  ///< added to the right-hand side at near dofs in the last trial
  NearField::Demand demand_;   ///< of the last trial
  NearField::Solution solution_;
  Trial trial_;
  OwnedVec u_;  ///< of the trial
  OwnedVec v_;
  OwnedVec reaction_;
  OwnedVec rhs_;
  OwnedVec work_;
};

template <class Displacement, class Velocity>
Trial CondensedIntegrator::near_trial(Displacement&& u_of, Velocity&& v_of) {
  Entries u(u_.get());
  Entries v(v_.get());
  Entries reaction(reaction_.get());
  for (std::size_t i = 0; i < near_.coordinates().size(); ++i) {
    const int dof = near_.coordinates()[i];
    if (!u.owns(dof)) continue;
    u[dof] = u_of(i);
    v[dof] = v_of(i);
    reaction[dof] = solution_.reaction[i];
  }
  return at_end(u_.get(), v_.get(), {reaction_.get(), solution_.lambda});
}

}  // namespace stylet
