// A body of which all dofs but one are held: one mass on one spring, stepped by the real integrators.
#pragma once

#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/dynamics/quasi_static.hpp"

#include "support/body.hpp"

#include <array>
#include <memory>

namespace stylet {

class Oscillator {
 public:
  /// mass: lumped for explicit stepping.
  explicit Oscillator(const TimeParameters& time, std::optional<RayleighDamping> damping = {})
      : body_(rectangle({.columns = 2, .rows = 2}), parameters(time, damping)) {
    for (int node = 0; node < body_.mesh.n_nodes(); ++node) {
      if (!body_.mesh.on_boundary(node)) dof_ = 2 * node;
    }
    const auto value = [&](Mat matrix) {
      PetscScalar entry = 0;
      check(MatGetValue(matrix, dof_, dof_, &entry));
      return entry;
    };
    const double k = value(body_.tissue.stiffness());
    const bool lumped = body_.tissue.mass() == nullptr;
    const double m = lumped ? gather_all(body_.tissue.lumped_mass())[static_cast<std::size_t>(dof_)]
                            : value(body_.tissue.mass());
    omega_ = std::sqrt(k / m);
    mass_ = m;
    const std::vector<int> free{dof_};
    held_ = held(others(body_.tissue, free));
    load_ = body_.tissue.make_vector();
    check(VecSet(load_.get(), 0));
    state_ = still(body_.tissue);
    if (time.method == TimeMethod::explicit_newmark) {
      integrator_ = std::make_unique<ExplicitNewmark>(body_.tissue, body_.mesh, time);
    } else if (time.method == TimeMethod::quasi_static) {
      integrator_ = std::make_unique<QuasiStatic>(body_.tissue, body_.mesh);
    } else {
      integrator_ = std::make_unique<ImplicitNewmark>(body_.tissue, body_.mesh, time);
    }
  }

  [[nodiscard]] double omega() const { return omega_; }  ///< rad/s
  [[nodiscard]] double mass() const { return mass_; }    ///< kg

  /// By a dashpot between the mass and what moves at `speed`.
  void drag(double coefficient, double speed) { held_.dashpots = {{dof_, coefficient, speed}}; }

  /// u, v, a of the free dof.
  using Values = std::array<double, 3>;
  void set(const Values& values) {
    set_owned(state_.u.get(), dof_, values[0]);
    set_owned(state_.v.get(), dof_, values[1]);
    set_owned(state_.a.get(), dof_, values[2]);
  }
  [[nodiscard]] Values get() const {
    const Vec vectors[3] = {state_.u.get(), state_.v.get(), state_.a.get()};
    const int dofs[1] = {dof_};
    const auto values = gather(vectors, dofs);
    return {values[0][0], values[1][0], values[2][0]};
  }
  void step(double h) { stylet::take_step(*integrator_, state_, load_.get(), h, held_); }

 private:
  static TissueParameters parameters(const TimeParameters& time,
                                     const std::optional<RayleighDamping>& damping) {
    const bool is_explicit = time.method == TimeMethod::explicit_newmark;
    auto p =
        material({1, 0.3, 1}, Plane::stress, is_explicit ? MassKind::lumped : MassKind::consistent);
    p.damping = damping;
    return p;
  }

  Slab body_;
  int dof_ = -1;
  double omega_ = 0;
  double mass_ = 0;
  ConstraintSet held_;
  OwnedVec load_;
  State state_;
  std::unique_ptr<TimeIntegrator> integrator_;
};

}  // namespace stylet
