// One step of time, tried as often as contact laws ask for and accepted once.
#pragma once

#include "stylet/base/archive.hpp"
#include "stylet/dynamics/state.hpp"
#include "stylet/fem/tissue_operator.hpp"
#include "stylet/solvers/constraint_set.hpp"

#include <optional>
#include <span>
#include <string>

namespace stylet {

/// What given motion needs.
struct HoldingForces {
  Vec reaction = nullptr;  ///< at each prescribed dof (N), zero elsewhere
  double lambda = 0;       ///< multiplier of the mean condition (N), 0 without one
};

/// The end of a step as tried. The vectors are lent until the next call.
///
/// Where given motion begins, or changes its speed, at once, the tissue gets a blow: an impulse, which
/// over a step counts as a force that grows without bound on shorter ones.
struct Trial {
  Vec u = nullptr;  ///< displacement at the end of the step (m)
  Vec v = nullptr;  ///< velocity (m/s)
  /// With any blow: they exclude that the tissue moves otherwise.
  HoldingForces needed;
  /// These times the displacements of the step are the work.
  HoldingForces working;
  /// At the end of the step, after any blow: what cuts, punctures and is reported.
  HoldingForces settled;
  int iterations = 0;  ///< of linear solvers

  // How the scheme books the work of the step.
  /// Weight of the forces at its end, those at its start have the rest: what makes the work exact.
  double end_weight = 0.5;
  double blow_work = 0;     ///< done by blows, apart from the working forces (J)
  double damping_work = 0;  ///< of `finish`: done on damping (J)
  /// Done by the load of its end, where that stood (J); none if the scheme does not sum it.
  std::optional<double> load_work = std::nullopt;
  /// tau (s): what is conserved is 1/2 v M v + 1/2 u K u - 1/2 tau^2 a M a.
  double swing_time = 0;
};

/// A row of a track in the last trial, which the vectors do not hold. The compliance behind it has no mass, so
/// that no motion comes to it as a blow.
struct RowTrial {
  double start;     ///< displacement at the start of the step (m)
  double u;         ///< at its end
  double v;         ///< mean velocity of the step (m/s)
  double reaction;  ///< N, needed by what is given there
};

/// Forces at the end of a step without a blow.
[[nodiscard]] inline Trial at_end(Vec u, Vec v, HoldingForces forces) {
  Trial trial;
  trial.u = u;
  trial.v = v;
  trial.needed = trial.working = trial.settled = forces;
  return trial;
}

/// What a state stores (J).
struct StoredEnergy {
  double kinetic = 0;
  double strain = 0;
};

/// How a run is kept from making energy.
struct EnergyRules {
  bool inertia = true;       ///< mass stores energy
  int interval = 1;          ///< steps from one look at the energy to the next
  double largest_swing = 1;  ///< kinetic and strain energy over what was supplied, if stable
  const char* advice = "";   ///< what makes less of energy that grew
  /// Of a scheme that carries on what interpolation at moved nodes adds: why that is more than all work.
  const char* edits_advice = nullptr;
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

  /// Collective. The next trials must hold the values of these dofs, whatever their constraints, or of these
  /// rows of the track that is followed (coordinate_of).
  virtual void watch(std::span<const int> coordinates) = 0;

  /// Rows are of this track from now on; lent.
  virtual void follow(const TrackOperator& track);
  /// Collective, between steps. There are no rows any more, and no forces on them.
  virtual void leave_track();
  /// Of a watched row.
  [[nodiscard]] virtual RowTrial row(int coordinate) const;

  /// Collective. The end of the step under these constraints of dofs that are not held, from the
  /// state as it is now (an edit may have changed it since the last trial: `edited`). What it returns
  /// holds at watched and constrained dofs. No answer if `stable_step` then says less than the step: it
  /// has to begin anew, shorter. Throws NumericalError if there is none.
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

  /// Collective, between `accept` and `begin`. Energy of the state; costs no product with K or M where
  /// the step had them.
  [[nodiscard]] virtual StoredEnergy energy(const State& state) = 0;
  [[nodiscard]] virtual EnergyRules energy_rules() const = 0;

  /// What solves for the whole tissue, and who chose it; for the record.
  [[nodiscard]] virtual std::string solver() const { return "none"; }

  /// The largest step that is right now (s): that is stable, or half of a step in which motion begins.
  /// Infinity if none is.
  [[nodiscard]] virtual double stable_step() const = 0;

  /// Tells which cells changed, after the tissue's update.
  virtual void touched(const Mesh& mesh, std::span<const int> cells) = 0;

  /// Collective, between two steps. The tissue has other matrices or another damping in all its rows; the
  /// state is kept.
  virtual void renewed(const Mesh& mesh) = 0;

  /// True if positions at the end of a step do not feel the forces of its end (central difference):
  /// contact is then decided by velocities.
  [[nodiscard]] virtual bool decides_by_velocity() const = 0;

  /// Collective, between steps and after `complete`: what is carried from step to step beside the state,
  /// and is not found anew from it. Loaded into a new integrator.
  virtual void archive(Archive& archive) = 0;
  /// After that, as if these had been those of the last step.
  virtual void go_on(State&, Vec /*load*/, std::span<const PrescribedDof> /*held*/) {}
};

/// Collective. One step under constraints that are known, in steps of half the length where motion begins.
inline void take_step(TimeIntegrator& integrator,
                      State& state,
                      Vec load,
                      double h,
                      const ConstraintSet& constraints) {
  const auto attempt = [&](double length) {
    integrator.begin(state, load, length, constraints.dofs);
    integrator.attempt({{}, constraints.mean, constraints.forces, constraints.dashpots}, false);
  };
  const auto accept = [&] {
    integrator.finish(true);
    integrator.accept();
  };
  attempt(h);
  if (!integrator.decides_by_velocity() && integrator.stable_step() < h) {
    attempt(0.5 * h);
    accept();
    attempt(0.5 * h);
  }
  accept();
}

}  // namespace stylet
