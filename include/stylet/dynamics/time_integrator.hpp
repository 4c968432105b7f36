// One step of time, tried as often as contact laws ask for and accepted once.
#pragma once

#include "stylet/dynamics/constraint_set.hpp"
#include "stylet/dynamics/state.hpp"
#include "stylet/fem/tissue_operator.hpp"

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
  /// (N). Both are lent until `accept`.
  virtual void begin(State& state, Vec load, double h) = 0;

  /// Collective. The end of the step under these constraints, from the state as it is now (an edit
  /// may have changed it since the last trial: `edited`). Throws NumericalError if a solver did not
  /// converge.
  virtual Trial attempt(const ConstraintSet& constraints, bool edited) = 0;

  /// Collective. The last trial becomes the state.
  virtual void accept() = 0;

  /// The largest step that is stable now (s); infinity if unconditionally stable.
  [[nodiscard]] virtual double stable_step() const = 0;

  /// Tells which cells changed, for the stable step.
  virtual void touched(const Mesh& mesh, std::span<const int> cells) = 0;

  /// True if positions at the end of a step do not feel the forces of its end (central difference):
  /// contact is then decided by velocities.
  [[nodiscard]] virtual bool decides_by_velocity() const = 0;
};

}  // namespace stylet
