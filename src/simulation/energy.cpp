#include "stylet/simulation/energy.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace stylet {

namespace {

// Energy without work ends the run above this share of the largest energy so far. Seen on scenes
// with a needle: 1e-6 with average acceleration, backward Euler and quasi-static, whose energy
// balance is exact but for contacts that change; 1.2 % with generalised-alpha in its first steps;
// 2 % with explicit steps, whose length changes with the mesh.
constexpr double allowed_excess = 0.05;

double dot(Vec x, Vec y) {
  PetscScalar value = 0;
  check(VecDot(x, y, &value));
  return value;
}

}  // namespace

double kinetic_energy(const TissueOperator& tissue, Vec v, Vec work) {
  tissue.apply_mass(v, work);
  return 0.5 * dot(v, work);
}

double EnergyLedger::within(const TissueOperator& tissue,
                            std::span<const int> nodes,
                            const State& state) const {
  const Vec vectors[3] = {state.u.get(), state.v.get(), state.a.get()};
  const auto fields = gather(vectors, dofs_of(nodes));
  // x . A x; along(row, each) goes along a row of A.
  const auto product = [&](const std::vector<double>& x, auto&& along) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const int row = 2 * nodes[i / 2] + static_cast<int>(i % 2);
      if (!tissue.owns(row / 2)) continue;
      auto at = nodes.begin();
      along(row, [&](int column, double value) {
        while (at != nodes.end() && *at < column / 2) ++at;
        if (at == nodes.end() || *at != column / 2) return;
        sum += x[i] * value * x[static_cast<std::size_t>(2 * (at - nodes.begin()) + column % 2)];
      });
    }
    return sum;
  };
  double twice = product(fields[0], [&](int row, auto&& each) { tissue.along_row(row, each); });
  if (rules_.inertia && tissue.mass() != nullptr) {
    twice += product(fields[1], [&](int row, auto&& each) { along_row(tissue.mass(), row, each); });
  } else if (rules_.inertia) {
    const Values mass(tissue.lumped_mass());
    for (std::size_t i = 0; i < fields[1].size(); ++i) {
      const int dof = 2 * nodes[i / 2] + static_cast<int>(i % 2);
      if (!tissue.owns(dof / 2)) continue;
      const double swing = swing_time_ * fields[2][i];
      twice += mass[dof] * (fields[1][i] * fields[1][i] - swing * swing);
    }
  }
  if (size_of(tissue.comm()) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, &twice, 1, MPI_DOUBLE, MPI_SUM, tissue.comm());
  }
  return 0.5 * twice;
}

EnergyLedger::EnergyLedger(const TissueOperator& tissue,
                           const Mesh& mesh,
                           const EnergyRules& rules,
                           double thickness)
    : rules_(rules), increment_(tissue.make_vector()), work_(tissue.make_vector()) {
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
  if (swing_time_ > 0 && end.swing_time != swing_time_) {
    // What is conserved depends on the length of the step.
    energies_.edits += (swing_time_ * swing_time_ - end.swing_time * end.swing_time) *
                       kinetic_energy(tissue, start.a.get(), work_.get());
  }
  swing_time_ = end.swing_time;
  energies_.external += external;
  energies_.dissipated += dissipated;
  energies_.dissipated += end.damping_work;
  if (end.load_work && load0 == nullptr) {
    energies_.external += *end.load_work;
  } else if (load1 != nullptr) {
    check(VecWAXPY(increment_.get(), -1, start.u.get(), end.u));
    const double at_end = dot(load1, increment_.get());
    const double at_start = load0 == nullptr ? at_end : dot(load0, increment_.get());
    energies_.external += (1 - end.end_weight) * at_start + end.end_weight * at_end;
    if (swing_time_ > 0) energies_.external += onset_work(tissue, end, h, load0, load1);
  }
}

// What a load does that begins at the end of an explicit step: half a step is already under it, so that
// tissue at rest has a velocity, but no displacement to give the mean load work. It is what it adds to
// h^2/8 a M a. increment_: of this step.
double EnergyLedger::onset_work(
    const TissueOperator& tissue, const Trial& end, double h, Vec load0, Vec load1) const {
  const double damped = 1 + 0.5 * h * tissue.damping().value_or(RayleighDamping{}).mass_factor;
  double sum = 0;
  {
    const Values before(load0);
    const Values after(load1);
    const Values v(end.v);
    const Values increment(increment_.get());
    const Values mass(tissue.lumped_mass());
    for (int dof = tissue.first_dof(); dof < tissue.end_dof(); ++dof) {
      const double change = (after[dof] - before[dof]) / (mass[dof] * damped);
      const double a = (v[dof] - increment[dof] / h) * 2 / h;
      if (change != 0 && a != 0) sum += mass[dof] * change * (2 * a - change);  // else it is held
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, tissue.comm());
  return h * h / 8 * sum;
}

void EnergyLedger::measure(const StoredEnergy& stored,
                           const TissueOperator& tissue,
                           const State& state) {
  static const LogEvent event("StyletEnergy");
  const LogScope scope(event);
  energies_.kinetic = stored.kinetic;
  energies_.strain = stored.strain;
  if (swing_time_ > 0) {
    swing_ = swing_time_ * swing_time_ * kinetic_energy(tissue, state.a.get(), work_.get());
  }
}

double EnergyLedger::conserved(const StoredEnergy& stored,
                               const TissueOperator& tissue,
                               const State& state) {
  measure(stored, tissue, state);
  return energies_.kinetic + energies_.strain - swing_;
}

void EnergyLedger::weigh(const StoredEnergy& stored,
                         const TissueOperator& tissue,
                         const State& state) {
  measure(stored, tissue, state);
  compare();
}

void EnergyLedger::compare() {
  unchecked_ = 0;
  const double mechanical = energies_.kinetic + energies_.strain;
  const double supplied = energies_.external + energies_.edits - energies_.dissipated;
  largest_ = std::max({largest_, std::abs(energies_.external), energies_.dissipated});
  const double excess = std::max(mechanical - swing_ - supplied,
                                 mechanical - rules_.largest_swing * std::max(supplied, 0.0));
  worst_excess_ = std::max(worst_excess_, excess / largest_);
  if (!checks_) return;
  if (rules_.edits_advice != nullptr && energies_.edits > largest_) {
    char text[300];
    std::snprintf(text, sizeof text,
                  "edits of the mesh added %.4g J, more than all work done, %.4g J: %s",
                  energies_.edits, largest_, rules_.edits_advice);
    throw NumericalError(text);
  }
  if (std::isfinite(mechanical) && excess <= allowed_excess * largest_) return;
  char text[400];
  std::snprintf(text, sizeof text,
                "energy grew without work: kinetic %.4g J and strain energy %.4g J, but external "
                "work less dissipation is %.4g J (allowed: %g %% of the largest energy so far, "
                "%.4g J, above it); take %s",
                energies_.kinetic, energies_.strain, supplied, 100 * allowed_excess, largest_,
                rules_.advice);
  throw NumericalError(text);
}

}  // namespace stylet
