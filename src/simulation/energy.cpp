#include "stylet/simulation/energy.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace stylet {

namespace {

// Energy without work ends the run above this share of the largest energy so far. Seen on scenes
// with a needle: 1e-6 with average acceleration, backward Euler and quasi-static, whose energy
// balance is exact but for contacts that change; 1.2 % with generalised-alpha in its first steps;
// 3 % with explicit steps, where edits are not booked.
constexpr double allowed_excess = 0.05;
constexpr int explicit_interval = 20;  // a K product in twenty steps costs below 5 %

double dot(Vec x, Vec y) {
  PetscScalar value = 0;
  check(VecDot(x, y, &value));
  return value;
}

// Central difference conserves ½ v M v + ½ u K u - h²/8 a M a. With (omega h)² / 4 up to safety² the
// first two alone swing above it by 1 / (1 - safety²).
double swing_of(const TimeParameters& time) {
  if (time.method != TimeMethod::explicit_newmark) return 1;
  constexpr double most = 0.9;
  return 1 / (1 - std::pow(std::min(time.safety, most), 2));
}

}  // namespace

double kinetic_energy(const TissueOperator& tissue, Vec v, Vec work) {
  tissue.apply_mass(v, work);
  return 0.5 * dot(v, work);
}

double strain_energy(const TissueOperator& tissue, Vec u, Vec work) {
  check(MatMult(tissue.stiffness(), u, work));
  return 0.5 * dot(u, work);
}

EnergyLedger::EnergyLedger(const TissueOperator& tissue,
                           const Mesh& mesh,
                           const TimeParameters& time,
                           double thickness)
    : inertia_(time.method != TimeMethod::quasi_static),
      end_weight_(time.method == TimeMethod::implicit_newmark &&
                          time.scheme == ImplicitScheme::backward_euler
                      ? 1
                      : 0.5),
      swing_(swing_of(time)),
      interval_(time.method == TimeMethod::explicit_newmark ? explicit_interval : 1),
      increment_(tissue.make_vector()),
      work_(tissue.make_vector()) {
  // Strains that are round-off and solver tolerance.
  constexpr double noise = 1e-10;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    largest_ += noise * noise * tissue.moduli(c).mu * thickness * mesh.cell_measure(c);
  }
}

void EnergyLedger::add(const TissueOperator& tissue,
                       const State& start,
                       const Trial& end,
                       double h,
                       Vec load0,
                       Vec load1,
                       double external,
                       double dissipated) {
  ++unchecked_;
  energies_.external += external;
  energies_.dissipated += dissipated;
  const bool damped = inertia_ && tissue.damping();
  if (!damped && load1 == nullptr) return;
  check(VecWAXPY(increment_.get(), -1, start.u.get(), end.u));
  if (load1 != nullptr) {
    energies_.external += (1 - end_weight_) * dot(load0, increment_.get()) +
                          end_weight_ * dot(load1, increment_.get());
  }
  if (!damped) return;
  // In every scheme the mean velocity of a step is increment / h, and damping acts on it.
  const RayleighDamping damping = *tissue.damping();
  double twice = 0;
  if (damping.mass_factor != 0) {
    tissue.apply_mass(increment_.get(), work_.get());
    twice += damping.mass_factor * dot(increment_.get(), work_.get());
  }
  if (damping.stiffness_factor != 0) {
    check(MatMult(tissue.stiffness(), increment_.get(), work_.get()));
    twice += damping.stiffness_factor * dot(increment_.get(), work_.get());
  }
  energies_.dissipated += twice / h;
}

void EnergyLedger::measure(const TissueOperator& tissue, const State& state) {
  static const LogEvent event("StyletEnergy");
  const LogScope scope(event);
  if (inertia_) {
    energies_.kinetic = kinetic_energy(tissue, state.v.get(), work_.get());
  }
  energies_.strain = strain_energy(tissue, state.u.get(), work_.get());
}

void EnergyLedger::edited(const TissueOperator& tissue, const State& state) {
  if (interval_ > 1) return;
  const double before = energies_.kinetic + energies_.strain;
  measure(tissue, state);
  energies_.edits += energies_.kinetic + energies_.strain - before;
}

void EnergyLedger::weigh(const TissueOperator& tissue, const State& state) {
  if (unchecked_ == 0) return;
  measure(tissue, state);
  compare();
}

void EnergyLedger::weigh(double strain) {
  energies_.strain = strain;
  compare();
}

void EnergyLedger::compare() {
  unchecked_ = 0;
  const double mechanical = energies_.kinetic + energies_.strain;
  const double supplied = energies_.external + energies_.edits - energies_.dissipated;
  largest_ = std::max({largest_, std::abs(energies_.external), energies_.dissipated});
  const double excess = mechanical - swing_ * std::max(0.0, supplied);
  worst_excess_ = std::max(worst_excess_, -energies_.balance_error() / largest_);
  if (!checks_) return;
  if (std::isfinite(mechanical) && excess <= allowed_excess * largest_) return;
  char text[400];
  std::snprintf(text, sizeof text,
                "energy grew without work: kinetic %.4g J and strain energy %.4g J, but external "
                "work less dissipation is %.4g J (allowed: %g %% of the largest energy so far, "
                "%.4g J, above it); take a smaller time.step or time.safety, or a finer mesh",
                energies_.kinetic, energies_.strain, supplied, 100 * allowed_excess, largest_);
  throw NumericalError(text);
}

}  // namespace stylet
