// Where the energy of a run is, and the end of a run that makes energy.
#pragma once

#include "stylet/dynamics/parameters.hpp"
#include "stylet/dynamics/time_integrator.hpp"

namespace stylet {

/// Sums since the start (J). balance_error = external + edits - (kinetic + strain + dissipated): the
/// numerical damping of the scheme, and mistakes.
struct Energies {
  double kinetic = 0;
  double strain = 0;
  double dissipated = 0;  ///< by damping, friction and cutting
  /// Done by the needle's hand, loads and prescribed curves, and by who changes the tissue in mid-run.
  double external = 0;
  /// Got where moved nodes took interpolated fields, and where explicit steps changed their length.
  double edits = 0;
  [[nodiscard]] double balance_error() const {
    return external + edits - (kinetic + strain + dissipated);
  }
};

/// Of the tissue (J); work: a vector of dofs, overwritten. Collective.
[[nodiscard]] double kinetic_energy(const TissueOperator& tissue, Vec v, Vec work);

/// Work is summed in every step, by what is declared: nothing without damping and loads. Kinetic and
/// strain energy are the integrator's: of every implicit step, which knows them, and every twentieth
/// explicit one, where they cost a pass over the mesh. What edits add is measured on their own rows.
class EnergyLedger {
 public:
  EnergyLedger(const TissueOperator& tissue,
               const Mesh& mesh,
               const TimeParameters& time,
               double thickness);

  /// Kinetic and strain energy (J) of the couplings among these nodes, ascending: it changes by as much
  /// as that of the tissue where only rows and fields of these nodes change, and no row of a node
  /// whose field changes leaves them. Collective; costs what the nodes are.
  [[nodiscard]] double within(const TissueOperator& tissue,
                              std::span<const int> nodes,
                              const State& state) const;
  /// What an edit added (J).
  void edited(double change) { energies_.edits += change; }

  /// Collective. What the scheme conserves of kinetic and strain energy (J).
  [[nodiscard]] double conserved(const StoredEnergy& stored,
                                 const TissueOperator& tissue,
                                 const State& state);
  /// The tissue was changed between two steps, and stores as much more (J).
  void changed(double more) { energies_.external += more; }

  /// Collective, before the trial is accepted. load0, load1: forces at its start, none if
  /// the same, and at its end (N), or none; external and dissipated: work by needle and prescribed curves (J).
  void add(const TissueOperator& tissue,
           const State& start,
           const Trial& end,
           double h,
           Vec load0,
           Vec load1,
           double external,
           double dissipated);

  /// Weight of the forces at the end of a step, those at its start have the rest: what makes the
  /// work exact in the scheme.
  [[nodiscard]] double end_weight(const Trial& trial) const {
    return trial.only_end ? 1 : end_weight_;
  }
  /// True if kinetic and strain energy are of an earlier step.
  [[nodiscard]] bool unchecked() const { return unchecked_ > 0; }
  [[nodiscard]] bool due() const { return unchecked_ >= interval_; }

  /// Collective, after a step. Kinetic and strain energy for the record; what is checked, and when, does
  /// not depend on it.
  void measure(const StoredEnergy& stored, const TissueOperator& tissue, const State& state);
  /// Collective, after a step. Throws NumericalError if there is more energy than work was done.
  void weigh(const StoredEnergy& stored, const TissueOperator& tissue, const State& state);

  /// For states that are changed from outside.
  void stop_checks() { checks_ = false; }

  [[nodiscard]] const Energies& energies() const { return energies_; }
  /// The most that the energy ever exceeded the work, as a share of the largest energy until then.
  [[nodiscard]] double worst_excess() const { return worst_excess_; }

 private:
  void compare();
  [[nodiscard]] double onset_work(
      const TissueOperator& tissue, const Trial& end, double h, Vec load0, Vec load1) const;

  bool inertia_;
  double end_weight_;
  bool is_explicit_;
  const char* advice_;    ///< of the message that ends a run
  double largest_swing_;  ///< kinetic and strain energy over what was supplied, if stable
  double swing_ = 0;      ///< by which they are above it now (J): h²/8 a M a
  double h_ = 0;          ///< of the last step (s)
  int interval_;
  int unchecked_ = 0;
  bool checks_ = true;
  double largest_ = 0;  ///< energy so far, at least that of round-off (J)
  double worst_excess_ = 0;
  Energies energies_;
  OwnedVec increment_;
  OwnedVec work_;
  OwnedVec half_velocity_;  ///< of the last explicit step, where stiffness damps
};

}  // namespace stylet
