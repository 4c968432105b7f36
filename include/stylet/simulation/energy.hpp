// Where the energy of a run is.
#pragma once

#include "stylet/dynamics/state.hpp"
#include "stylet/fem/tissue_operator.hpp"

namespace stylet {

/// Sums since the start (J). balance_error = external - (kinetic + strain + dissipated): the
/// numerical damping of the scheme, the interpolation of fields after edits, and mistakes.
struct Energies {
  double kinetic = 0;
  double strain = 0;
  double dissipated = 0;  ///< by damping, friction and cutting
  double external = 0;    ///< done by the needle's hand, loads and prescribed curves
  [[nodiscard]] double balance_error() const { return external - (kinetic + strain + dissipated); }
};

class EnergyLedger {
 public:
  /// Collective. inertia: false for quasi-static.
  EnergyLedger(const TissueOperator& tissue, const State& state, bool inertia);

  /// Collective, after a step of length h. load0, load1: forces at its start and end (N); prescribed
  /// work and dissipation by the needle (J) of this step.
  void add(const TissueOperator& tissue,
           const State& state,
           double h,
           Vec load0,
           Vec load1,
           double external_work,
           double dissipated);

  [[nodiscard]] const Energies& energies() const { return energies_; }

 private:
  double damping_power(const TissueOperator& tissue, const State& state);

  bool inertia_;
  Energies energies_;
  double power_ = 0;
  OwnedVec last_u_;
  OwnedVec work_;
};

}  // namespace stylet
