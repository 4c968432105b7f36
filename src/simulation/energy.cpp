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
constexpr int explicit_interval = 20;  // a K product in twenty steps costs below 5 %

// Central difference conserves ½ v M v + ½ u K u - h²/8 a M a. With (omega h)² / 4 up to safety² the
// first two alone swing above it by 1 / (1 - safety²); unstable steps conserve it too, while all three
// grow.
double largest_swing(const TimeParameters& time) {
  constexpr double most = 0.9;
  return 1 / (1 - std::pow(std::min(time.safety, most), 2));
}

// What makes less of what grew.
const char* advice(const TimeParameters& time) {
  if (time.method == TimeMethod::explicit_newmark) {
    return "a smaller time.safety, a finer mesh, or time.method implicit";  // steps are stable ones
  }
  const bool keeps_waves =
      time.method == TimeMethod::implicit_newmark && time.scheme != ImplicitScheme::backward_euler;
  return keeps_waves ? "a smaller time.step, or time.scheme backward_euler, which damps waves"
                     : "a smaller time.step, or a finer mesh";
}

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
  const auto product = [&](Mat matrix, const std::vector<double>& x) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const int row = 2 * nodes[i / 2] + static_cast<int>(i % 2);
      if (!tissue.owns(row / 2)) continue;
      PetscInt n = 0;
      const PetscInt* columns = nullptr;
      const PetscScalar* values = nullptr;
      check(MatGetRow(matrix, row, &n, &columns, &values));
      auto at = nodes.begin();
      for (PetscInt j = 0; j < n; ++j) {
        at = std::find_if(at, nodes.end(), [&](int node) { return node >= columns[j] / 2; });
        if (at == nodes.end()) break;
        if (*at != columns[j] / 2) continue;
        const auto column = static_cast<std::size_t>(2 * (at - nodes.begin()) + columns[j] % 2);
        sum += x[i] * values[j] * x[column];
      }
      check(MatRestoreRow(matrix, row, &n, &columns, &values));
    }
    return sum;
  };
  double twice = product(tissue.stiffness(), fields[0]);
  if (inertia_ && tissue.mass() != nullptr) {
    twice += product(tissue.mass(), fields[1]);
  } else if (inertia_) {
    const Values mass(tissue.lumped_mass());
    for (std::size_t i = 0; i < fields[1].size(); ++i) {
      const int dof = 2 * nodes[i / 2] + static_cast<int>(i % 2);
      if (!tissue.owns(dof / 2)) continue;
      const double swing = is_explicit_ ? 0.5 * h_ * fields[2][i] : 0;
      twice += mass[dof] * (fields[1][i] * fields[1][i] - swing * swing);
    }
  }
  if (size_of(tissue.comm()) > 1) {
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &twice, 1, MPI_DOUBLE, MPI_SUM, tissue.comm()));
  }
  return 0.5 * twice;
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
      is_explicit_(time.method == TimeMethod::explicit_newmark),
      advice_(advice(time)),
      largest_swing_(is_explicit_ ? largest_swing(time) : 1),
      interval_(is_explicit_ ? explicit_interval : 1),
      increment_(tissue.make_vector()),
      work_(tissue.make_vector()),
      half_velocity_(tissue.make_vector()) {
  check(VecSet(half_velocity_.get(), 0));
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
  if (is_explicit_ && h_ > 0 && h != h_) {
    // What is conserved depends on the length of the step.
    energies_.edits +=
        0.25 * (h_ * h_ - h * h) * kinetic_energy(tissue, start.a.get(), work_.get());
  }
  h_ = h;
  energies_.external += external;
  energies_.dissipated += dissipated;
  const bool damped = inertia_ && tissue.damping();
  const RayleighDamping damping = damped ? *tissue.damping() : RayleighDamping{};
  energies_.dissipated += end.damping_work;
  if (end.all_damping_work) energies_.dissipated += *end.all_damping_work;
  const bool damps_mass = damping.mass_factor != 0 && !is_explicit_ && !end.all_damping_work;
  const bool damps_stiffness = damping.stiffness_factor != 0 && !end.all_damping_work;
  // A load that stands has its work from the pass of the explicit step.
  const bool passed = is_explicit_ && load0 == nullptr;
  if (passed) energies_.external += end.load_work;
  const bool loaded = load1 != nullptr && !passed;
  if (!damps_mass && !damps_stiffness && !loaded) return;
  check(VecWAXPY(increment_.get(), -1, start.u.get(), end.u));
  if (loaded) {
    const double at_end = dot(load1, increment_.get());
    const double at_start = load0 == nullptr ? at_end : dot(load0, increment_.get());
    energies_.external += (1 - end_weight(end)) * at_start + end_weight(end) * at_end;
    if (is_explicit_) energies_.external += onset_work(tissue, end, h, load0, load1);
  }
  // In implicit schemes damping acts on the mean velocity of the step, increment / h. Explicit ones take
  // for the forces of a time the velocity of that time to damp mass, which they book themselves, and
  // that of the half step before to damp stiffness.
  if (damps_mass) {
    tissue.apply_mass(increment_.get(), work_.get());
    energies_.dissipated += damping.mass_factor * dot(increment_.get(), work_.get()) / h;
  }
  if (damps_stiffness) {
    check(MatMult(tissue.stiffness(), increment_.get(), work_.get()));
    const double own = dot(increment_.get(), work_.get()) / h;
    const double done = is_explicit_ ? 0.5 * (own + dot(half_velocity_.get(), work_.get())) : own;
    energies_.dissipated += damping.stiffness_factor * done;
    if (!is_explicit_) return;
    check(VecCopy(increment_.get(), half_velocity_.get()));
    check(VecScale(half_velocity_.get(), 1 / h));
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
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, tissue.comm()));
  return h * h / 8 * sum;
}

void EnergyLedger::measure(const StoredEnergy& stored,
                           const TissueOperator& tissue,
                           const State& state) {
  static const LogEvent event("StyletEnergy");
  const LogScope scope(event);
  energies_.kinetic = stored.kinetic;
  energies_.strain = stored.strain;
  if (is_explicit_) swing_ = 0.25 * h_ * h_ * kinetic_energy(tissue, state.a.get(), work_.get());
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
                                 mechanical - largest_swing_ * std::max(supplied, 0.0));
  worst_excess_ = std::max(worst_excess_, excess / largest_);
  if (!checks_) return;
  if (is_explicit_ && energies_.edits > largest_) {
    // Implicit steps relax what an interpolated field adds; explicit ones carry it on as waves.
    char text[300];
    std::snprintf(
        text, sizeof text,
        "edits of the mesh added %.4g J, more than all work done, %.4g J: this tissue is too "
        "close to incompressible, or its elements too large, for explicit steps; take "
        "time.method implicit",
        energies_.edits, largest_);
    throw NumericalError(text);
  }
  if (std::isfinite(mechanical) && excess <= allowed_excess * largest_) return;
  char text[400];
  std::snprintf(text, sizeof text,
                "energy grew without work: kinetic %.4g J and strain energy %.4g J, but external "
                "work less dissipation is %.4g J (allowed: %g %% of the largest energy so far, "
                "%.4g J, above it); take %s",
                energies_.kinetic, energies_.strain, supplied, 100 * allowed_excess, largest_,
                advice_);
  throw NumericalError(text);
}

}  // namespace stylet
