// Where the energy of a run is, and the end of a run that makes energy.
#pragma once

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

/// Work is summed in every step. What a scheme does with energy, its trials and its rules tell. Kinetic
/// and strain energy are the integrator's: of every implicit step, which knows them, and every twentieth
/// explicit one, where they cost a pass over the mesh. What edits add is measured on their own rows.
class EnergyLedger {
 public:
  EnergyLedger(const TissueOperator& tissue,
               const Mesh& mesh,
               const EnergyRules& rules,
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

  /// True if kinetic and strain energy are of an earlier step.
  [[nodiscard]] bool unchecked() const { return unchecked_ > 0; }
  [[nodiscard]] bool due() const { return unchecked_ >= rules_.interval; }

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

  EnergyRules rules_;
  double swing_ = 0;  ///< by which kinetic and strain energy are above what is conserved now (J)
  double swing_time_ = 0;  ///< of the last step (s)
  int unchecked_ = 0;
  bool checks_ = true;
  double largest_ = 0;  ///< energy so far, at least that of round-off (J)
  double worst_excess_ = 0;
  Energies energies_;
  OwnedVec increment_;
  OwnedVec work_;
};

}  // namespace stylet
