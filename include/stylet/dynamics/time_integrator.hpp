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

  /// Strain energies (J) around a step that is not whole, from what is known near the needle: what
  /// edits before the last trial added, and that of the last trial. None if the step is whole.
  struct StrainEnergies {
    double edits = 0;
    double end = 0;
  };
  [[nodiscard]] virtual std::optional<StrainEnergies> strain_energies() { return std::nullopt; }

  /// The largest step that is stable now (s); infinity if unconditionally stable.
  [[nodiscard]] virtual double stable_step() const = 0;

  /// Tells which cells changed, after the tissue's update.
  virtual void touched(const Mesh& mesh, std::span<const int> cells) = 0;

  /// True if positions at the end of a step do not feel the forces of its end (central difference):
  /// contact is then decided by velocities.
  [[nodiscard]] virtual bool decides_by_velocity() const = 0;
};

}  // namespace stylet
