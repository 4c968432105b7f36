// Implicit time stepping: the Newmark family of the paper (sec. IV.B), with the load balance at the
// end of the step, where contact laws are read.
//
//   (1 - alpha_m) M a1 + alpha_m M a0 + C v1 + K u1 = f1
//   u1 = u0 + h v0 + h^2 (c0 a0 + c1 a1),  v1 = v0 + h (g0 a0 + g1 a1)
//
//   average acceleration   alpha_m = 0, c0 = c1 = 1/4, g0 = g1 = 1/2
//   generalised-alpha      alpha_f = 0 (Wood, Bossak, Zienkiewicz 1980), the member of the family of
//                          Chung and Hulbert (1993) that balances at the end of the step:
//                          alpha_m = (rho - 1)/(rho + 1), g1 = 1/2 - alpha_m, c1 = (1 - alpha_m)^2/4;
//                          rho = 1 is average acceleration
//   backward Euler         alpha_m = 0, c0 = g0 = 0, c1 = g1 = 1
//
// Given motion that begins, or changes its speed, between two steps. Schemes that balance the start of a
// step too carry what does not fit there on and on: a place that starts to move at speed V gets 2V, 0,
// 2V ..., and accelerations grow with every step. So such a step is refused (`stable_step` then says
// half of it), and this step and the next one, of half its length, are steps of backward Euler
// (Rannacher, Numer. Math. 43, 1984: damped start after rough data), which leave velocity and
// acceleration that fit. With average acceleration their operator is that of the whole step. Each has
// its own contacts. In backward Euler the blow is solved for with the mass alone and taken off the forces.
//
// Products with K and M are taken cell by cell. Backward Euler needs one pass a step: with K u1 and
// M v1, which also give the energies, K v1 = (K u1 - K u0)/h and M a1 = (M v1 - M v0)/h.
//
// Misprint in the paper: its displacement update takes the new velocity, u1 = u0 + h v1 + ...; read
// literally that is first order and unstable above omega h = 2/sqrt(3). It must be v0, as here.
#pragma once

#include "stylet/dynamics/condensed_integrator.hpp"
#include "stylet/dynamics/parameters.hpp"
#include "stylet/solvers/mass_solver.hpp"
#include "stylet/solvers/near_field.hpp"

#include <optional>
#include <vector>

namespace stylet {

struct StepCoefficients {
  double alpha_m = 0;
  double c0 = 0;
  double c1 = 1;
  double g0 = 0;
  double g1 = 1;
};

[[nodiscard]] StepCoefficients coefficients(ImplicitScheme scheme, double rho_infinity);

class ImplicitNewmark final : public CondensedIntegrator {
 public:
  /// The tissue is lent.
  ImplicitNewmark(TissueOperator& tissue, const Mesh& mesh, const TimeParameters& parameters);

  void begin(State& state, Vec load, double h, std::span<const PrescribedDof> held) override;
  void watch(std::span<const int> coordinates) override;
  Trial attempt(const ConstraintSet& constraints, bool edited) override;
  Trial finish(bool whole) override;
  void accept() override;
  void complete_at(std::span<const int> nodes) override;
  [[nodiscard]] double stable_step() const override {
    return damped_steps_ > 0 ? half_ : CondensedIntegrator::stable_step();
  }
  void touched(const Mesh& mesh, std::span<const int> cells) override;
  void renewed(const Mesh& mesh) override;
  void leave_track() override;
  [[nodiscard]] RowTrial row(int coordinate) const override;
  [[nodiscard]] EnergyRules energy_rules() const override;
  void archive(Archive& archive) override;

 private:
  /// Of the speed of given motion: less does not begin.
  static constexpr double at_once = 1e-6;

  void predict();
  void predict_by_products();
  void predict_edited();
  void refresh_near();
  void hold();
  void make_operator();
  void prepare();
  [[nodiscard]] bool needle_begins(const ConstraintSet& constraints);
  [[nodiscard]] bool damps_at_once() const { return k_.c0 == 0; }  ///< backward Euler in this step
  [[nodiscard]] double end_weight() const { return damps_at_once() ? 1 : 0.5; }
  [[nodiscard]] bool keeps_products() const { return scheme_.c0 == 0; }  ///< backward Euler in all
  [[nodiscard]] double increment_of(const PrescribedDof& c, double u, double v) const;
  Trial attempt_near(const ConstraintSet& constraints);
  void complete_near();
  void balance(Vec x, Vec residual);
  void balance_by_products(Vec x, Vec residual);
  void store_energy();
  void fit_given();
  void take_off_blow(const ConstraintSet& constraints);
  void blow_lumped(std::span<const DofValue> given, const MeanCondition* mean);
  void settle();
  [[nodiscard]] double speed() const { return k_.g1 / (k_.c1 * h_); }  ///< v1 = v_guess + speed x

  StepCoefficients scheme_;
  StepCoefficients k_;  ///< of this step: the scheme's, or a damped one
  double shift_v_ = 0;  ///< of the operator
  double shift_a_ = 0;
  Combination operator_;
  StateProducts products_;                  ///< with backward Euler
  std::size_t n_owned_;                     ///< dofs
  double largest_ = 0;                      ///< entry of rhs_base_
  bool fresh_ = true;                       ///< no trial yet
  int damped_steps_ = 0;                    ///< to come, with the present one
  double half_ = 0;                         ///< length of them (s)
  bool held_move_ = false;                  ///< some held dof has an increment
  bool held_begin_ = false;                 ///< one that its velocity does not explain
  double fastest_ = 0;                      ///< speed of given motion so far (m/s)
  std::vector<PrescribedDof> needle_dofs_;  ///< in this trial
  bool has_mean_ = false;
  bool had_mean_ = false;         ///< in the last step
  bool released_ = false;         ///< then
  std::vector<int> watched_;      ///< coordinates
  std::vector<int> surrounding_;  ///< what they couple to
  // Of the near dofs, in their order.
  std::vector<double> u_near_;  ///< predictors
  std::vector<double> v_near_;
  std::vector<double> change_;  ///< of the right-hand side by edits since `begin`
  std::vector<double> start_;   ///< displacement of rows at the start of the step (m), zero at dofs
  OwnedVec u_guess_;            ///< predictor of the step
  OwnedVec v_guess_;
  OwnedVec increment_;  ///< u1 - predictor = c1 h^2 a1, the unknown
  OwnedVec held_increment_;
  OwnedVec rhs_base_;  ///< at `begin`, less what increments of held dofs take
  bool has_blow_ = false;
  std::optional<MassSolver> mass_solver_;
  OwnedVec jump_;  ///< of velocity
  OwnedVec blow_;  ///< impulses (N s)
  double blow_lambda_ = 0;
  OwnedVec settled_;
};

/// Collective. Acceleration at the start from M a = f - C v - K u, zero at the prescribed dofs.
void initial_acceleration(const TissueOperator& tissue,
                          State& state,
                          Vec load,
                          const ConstraintSet& constraints);

}  // namespace stylet
