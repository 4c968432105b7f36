// One step of time, tried as often as contact laws ask for and accepted once.
#pragma once

#include "stylet/dynamics/constraint_set.hpp"
#include "stylet/dynamics/state.hpp"
#include "stylet/fem/tissue_operator.hpp"

#include <optional>
#include <span>

namespace stylet {

/// The end of a step as tried. The vectors are lent until the next call.
struct Trial {
  Vec u = nullptr;         ///< displacement at the end of the step (m)
  Vec v = nullptr;         ///< velocity (m/s)
  Vec reaction = nullptr;  ///< force that each prescribed dof needs (N), zero elsewhere
  double lambda = 0;       ///< multiplier of the mean condition (N), 0 without one
  int iterations = 0;      ///< of linear solvers
  /// Central difference only, where a contact that begins gives a blow at the end of the step: means of
  /// reaction and lambda just before and just after it, which are the forces that do work.
  Vec working = nullptr;
  double working_lambda = 0;
  [[nodiscard]] Vec working_reaction() const { return working != nullptr ? working : reaction; }
  [[nodiscard]] double working_multiplier() const {
    return working != nullptr ? working_lambda : lambda;
  }
  double blow_work = 0;     ///< done in this step by bringing dofs to their given places (J)
  double damping_work = 0;  ///< done on the damping of mass (J)
  double load_work = 0;     ///< done by the load of its end (J)
};

class TimeIntegrator {
 public:
  TimeIntegrator() = default;
  TimeIntegrator(const TimeIntegrator&) = delete;
  TimeIntegrator& operator=(const TimeIntegrator&) = delete;
  virtual ~TimeIntegrator() = default;

  /// Collective. Starts a step of length h from `state`, under the external forces `load` at its end
  /// (N). held: what holds the tissue apart from the needle. All are lent until `accept`; which dofs
  /// are held must not change from step to step, their values may.
  virtual void begin(State& state, Vec load, double h, std::span<const PrescribedDof> held) = 0;

  /// Collective. The next trials must hold the values of these nodes, whatever their constraints.
  virtual void watch(std::span<const int> nodes) = 0;

  /// Collective. The end of the step under these constraints of dofs that are not held, from the
  /// state as it is now (an edit may have changed it since the last trial: `edited`). What it returns
  /// holds at watched and constrained dofs. Throws NumericalError if there is no answer.
  virtual Trial attempt(const ConstraintSet& constraints, bool edited) = 0;

  /// Collective. The last trial at all dofs; at watched ones only if the integrator can postpone the
  /// rest and `whole` is false.
  virtual Trial finish(bool whole) = 0;

  /// Collective, after `finish`. The last trial becomes the state.
  virtual void accept() = 0;

  /// Collective. Brings the state up to date at all dofs, where steps were not whole.
  virtual void complete() {}
  /// Collective. At these nodes at least.
  virtual void complete_at(std::span<const int>) {}

  /// Collective. Strain energy (J) of the last trial from what is known near the needle. None if the
  /// step is whole: its displacements then tell.
  [[nodiscard]] virtual std::optional<double> strain_energy() const { return std::nullopt; }

  /// The largest step that is stable now (s); infinity if unconditionally stable.
  [[nodiscard]] virtual double stable_step() const = 0;

  /// Tells which cells changed, after the tissue's update.
  virtual void touched(const Mesh& mesh, std::span<const int> cells) = 0;

  /// True if positions at the end of a step do not feel the forces of its end (central difference):
  /// contact is then decided by velocities.
  [[nodiscard]] virtual bool decides_by_velocity() const = 0;
};

}  // namespace stylet
