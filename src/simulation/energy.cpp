#include "stylet/simulation/energy.hpp"

#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"

namespace stylet {

namespace {
double dot(Vec x, Vec y) {
  PetscScalar value = 0;
  check(VecDot(x, y, &value));
  return value;
}
}  // namespace

EnergyLedger::EnergyLedger(const TissueOperator& tissue, const State& state, bool inertia)
    : inertia_(inertia), last_u_(tissue.make_vector()), work_(tissue.make_vector()) {
  check(VecCopy(state.u.get(), last_u_.get()));
  power_ = damping_power(tissue, state);
}

// v . C v, and the kinetic energy on the way (W).
double EnergyLedger::damping_power(const TissueOperator& tissue, const State& state) {
  if (!inertia_) return 0;
  tissue.apply_mass(state.v.get(), work_.get());
  const double vmv = dot(state.v.get(), work_.get());
  energies_.kinetic = 0.5 * vmv;
  if (!tissue.damping()) return 0;
  double power = tissue.damping()->mass_factor * vmv;
  if (tissue.damping()->stiffness_factor != 0) {
    check(MatMult(tissue.stiffness(), state.v.get(), work_.get()));
    power += tissue.damping()->stiffness_factor * dot(state.v.get(), work_.get());
  }
  return power;
}

void EnergyLedger::add(const TissueOperator& tissue,
                       const State& state,
                       double h,
                       Vec load0,
                       Vec load1,
                       double external_work,
                       double dissipated) {
  static const LogEvent event("StyletEnergy");
  const LogScope scope(event);
  // Work of the loads by the mean force over the step.
  check(VecAXPY(last_u_.get(), -1, state.u.get()));
  energies_.external += external_work;
  if (load1 != nullptr) {
    energies_.external -= 0.5 * (dot(load0, last_u_.get()) + dot(load1, last_u_.get()));
  }
  check(VecCopy(state.u.get(), last_u_.get()));
  const double before = power_;
  power_ = damping_power(tissue, state);
  energies_.dissipated += dissipated + 0.5 * h * (before + power_);
  check(MatMult(tissue.stiffness(), state.u.get(), work_.get()));
  energies_.strain = 0.5 * dot(state.u.get(), work_.get());
}

}  // namespace stylet
