// Explicit time stepping with lumped mass: the paper's interactive mode (sec. IV.B, VI).
//
//   u1 = u0 + h v0 + h^2/2 a0
//   (M + h/2 C_m) a1 = f1 - K u1 - C (v0 + h/2 a0),   v1 = v0 + h/2 (a0 + a1)
//
// C_m = mass_factor M is diagonal and implicit; stiffness damping acts at the half-step velocity and
// lowers the stable step from 2/omega to 2 (sqrt(1 + xi^2) - xi)/omega, xi = stiffness_factor
// omega / 2. A prescribed dof has a1 = 0 and the given velocity, so that its reaction does not ring.
// The mean condition has w . a1 = 0 and the given rate, or a velocity that reaches its value at the end
// of the next step. The forces of contact are those that bring the free velocities to the given ones.
#pragma once

#include "stylet/dynamics/explicit_step.hpp"
#include "stylet/dynamics/explicit_track.hpp"
#include "stylet/dynamics/parameters.hpp"
#include "stylet/dynamics/time_integrator.hpp"
#include "stylet/fem/cell_operator.hpp"
#include "stylet/solvers/eigenvalue_bound.hpp"

#include <vector>

namespace stylet {

class ExplicitNewmark final : public TimeIntegrator {
 public:
  /// Collective. Needs a lumped tissue operator.
  ExplicitNewmark(TissueOperator& tissue, const Mesh& mesh, const TimeParameters& parameters);

  /// Throws InputError where damping by stiffness leaves next to nothing of the stable step.
  void require_bearable_damping() const;

  void begin(State& state, Vec load, double h, std::span<const PrescribedDof> held) override;
  void watch(std::span<const int> coordinates) override;
  void follow(const TrackOperator& track) override { track_.follow(track); }
  void leave_track() override;
  [[nodiscard]] RowTrial row(int coordinate) const override { return track_.row(coordinate); }
  Trial attempt(const ConstraintSet& constraints, bool edited) override;
  Trial finish(bool) override;
  void accept() override;
  /// Of the bound on the largest eigenvalue, times the safety factor.
  [[nodiscard]] double stable_step() const override;
  void touched(const Mesh& mesh, std::span<const int> cells) override;
  void renewed(const Mesh& mesh) override;
  /// Not in space, where the needle's place feels its forces at once.
  [[nodiscard]] bool decides_by_velocity() const override { return tissue_.dim() == 2; }
  [[nodiscard]] StoredEnergy energy(const State& state) override;
  [[nodiscard]] EnergyRules energy_rules() const override;
  void archive(Archive& archive) override;
  void go_on(State& state, Vec load, std::span<const PrescribedDof> held) override;

 private:
  struct FreeValue {
    PetscInt index;
    double v;
    double a;
  };
  /// Of the tip's condition (N), just before the end of the step and just after it.
  struct Multipliers {
    double before = 0;
    double after = 0;
  };
  void make_room();
  void advance(double h, Vec u, Vec v);
  void accelerate_again(std::span<const int> rows, std::span<const int> columns);
  void restore();
  [[nodiscard]] bool is_given(int dof, std::span<const PrescribedDof> dofs) const;
  [[nodiscard]] bool places_same_dofs(const ConstraintSet& constraints) const;
  Multipliers apply(const ConstraintSet& constraints);
  void push_by_track();

  TissueOperator& tissue_;
  double safety_;
  RayleighDamping damping_;
  EigenvalueBound bound_;
  std::vector<double> node_mass_;  ///< of owned nodes (kg)
  CellOperator cells_;
  std::vector<double> pressure_;  ///< room for it
  OwnedTs ts_;
  long long n_steps_ = 0;  ///< accepted
  State* state_ = nullptr;
  Vec load_ = nullptr;
  double h_ = 0;
  bool fresh_ = false;
  std::span<const PrescribedDof> held_;
  std::vector<PrescribedDof> dofs_;  ///< held ones and the needle's
  ExplicitTrack track_;              ///< of a needle in space
  Trial trial_;
  std::vector<FreeValue> overridden_;
  std::vector<int> placed_;        ///< dofs with a given place, of all ranks
  std::vector<GivenPlace> given_;  ///< the owned ones, by local index, ascending
  double placing_work_ = 0;        ///< by given places (J)
  double blow_work_ = 0;           ///< by contacts that begin (J)
  double free_damping_work_ = 0;   ///< by mass damping, before contact (J)
  double damping_work_ = 0;
  double load_work_ = 0;
  std::vector<DofValue> trial_contact_;  ///< forces of the needle just after the step (N)
  std::vector<DofValue> contact_;        ///< the same of the last accepted step
  std::vector<PrescribedDof> kept_;      ///< by the needle, there
  std::vector<int> written_;             ///< entries of forces that need not be zero
  OwnedVec u_;
  OwnedVec v_;
  OwnedVec a_;
  OwnedVec stretched_;         ///< with ghosts
  std::vector<double> force_;  ///< with ghosts, on several ranks
  OwnedVec needed_;
  OwnedVec working_;
  OwnedVec settled_;
  OwnedVec work_;
  OwnedVec increment_;      ///< of displacement in a step, where stiffness damps
  OwnedVec half_velocity_;  ///< of the last step, there
};

/// Stable step of one mode (s): omega^2 in (rad/s)^2, stiffness damping in s.
[[nodiscard]] double stable_step(double omega_squared, double stiffness_factor);

}  // namespace stylet
