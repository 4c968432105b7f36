#include "stylet/study/perturbation.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/simulation/energy.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>

namespace stylet {

namespace {

double speed_of(Vec v) {
  PetscReal norm = 0;
  check(VecNorm(v, NORM_2, &norm));
  return norm;
}

State at_rest(const TissueOperator& tissue) {
  State state{0, tissue.make_vector(), tissue.make_vector(), tissue.make_vector()};
  for (const Vec vec : {state.u.get(), state.v.get(), state.a.get()}) check(VecSet(vec, 0));
  return state;
}

// One mass is enough to grow, so the norm of all is watched against a bound that stable motion does
// not reach: just below the limit beats amount to 1 / sqrt(1 - (h/limit)^2), 22 at 0.1 % below it.
// At 0.1 % above it the velocity grows by exp(0.09) a step, with damping by exp(0.02) or so.
class ExplicitTrial {
 public:
  ExplicitTrial(TissueOperator& tissue, const Mesh& mesh, const ConstraintSet& held, Vec velocities)
      : held_(held),
        velocities_(velocities),
        integrator_(tissue, mesh, parameters()),
        state_(at_rest(tissue)),
        load_(tissue.make_vector()) {
    check(VecSet(load_.get(), 0));
  }

  [[nodiscard]] double predicted() const { return integrator_.stable_step(); }

  [[nodiscard]] bool grows(double h) {
    constexpr int most_steps = 2000;
    constexpr int steps_a_look = 25;
    constexpr double grown = 1e4;
    check(VecSet(state_.u.get(), 0));
    check(VecSet(state_.a.get(), 0));
    check(VecCopy(velocities_, state_.v.get()));
    const double bound = grown * speed_of(velocities_);
    for (int n = 1; n <= most_steps; ++n) {
      integrator_.begin(state_, load_.get(), h, held_.dofs);
      integrator_.attempt({{}, held_.mean, held_.forces, held_.dashpots}, false);
      integrator_.accept();
      if (n % steps_a_look == 0 && !(speed_of(state_.v.get()) <= bound)) return true;
    }
    return false;
  }

 private:
  static TimeParameters parameters() {
    TimeParameters time;
    time.method = TimeMethod::explicit_newmark;
    time.safety = 1;
    return time;
  }

  const ConstraintSet& held_;
  Vec velocities_;
  ExplicitNewmark integrator_;
  State state_;
  OwnedVec load_;
};

}  // namespace

std::unique_ptr<TissueOperator> tissue_at(MPI_Comm comm,
                                          const NumberedMesh& original,
                                          const Mesh& now,
                                          const TissueParameters& parameters) {
  auto tissue = std::make_unique<TissueOperator>(comm, original.mesh, original.first_node,
                                                 parameters, [](int) { return false; });
  std::vector<int> all(static_cast<std::size_t>(now.n_cells()));
  std::iota(all.begin(), all.end(), 0);
  tissue->update(now, all);
  return tissue;
}

ConstraintSet homogeneous(ConstraintSet constraints) {
  for (auto& dof : constraints.dofs) dof = {dof.dof, 0.0};
  if (constraints.mean) constraints.mean->value = constraints.mean->rate = 0;
  constraints.forces.clear();
  constraints.dashpots.clear();
  return constraints;
}

OwnedVec random_velocities(const TissueOperator& tissue,
                           const NumberedMesh& original,
                           const ConstraintSet& constraints) {
  constexpr double size = 1e-3;
  OwnedVec v = tissue.make_vector();
  check(VecSet(v.get(), 0));
  std::mt19937 engine;
  std::uniform_real_distribution<double> random(-size, size);
  for (const int node : original.new_of_old_node) {
    set_owned(v.get(), 2 * node, random(engine));
    set_owned(v.get(), 2 * node + 1, random(engine));
  }
  const auto release = [&](Vec vec) {
    for (const auto& dof : constraints.dofs) set_owned(vec, dof.dof, 0);
  };
  release(v.get());
  if (constraints.mean) {
    OwnedVec weights = tissue.make_vector();
    check(VecSet(weights.get(), 0));
    for (const auto& [dof, weight] : constraints.mean->weights) {
      set_owned(weights.get(), dof, weight);
    }
    release(weights.get());
    PetscScalar along = 0;
    PetscScalar square = 0;
    check(VecDot(weights.get(), v.get(), &along));
    check(VecDot(weights.get(), weights.get(), &square));
    if (square > 0) check(VecAXPY(v.get(), -along / square, weights.get()));
  }
  return v;
}

MeasuredLimit measured_limit(TissueOperator& tissue,
                             const Mesh& mesh,
                             const ConstraintSet& constraints,
                             Vec velocities) {
  ExplicitTrial trial(tissue, mesh, constraints, velocities);
  constexpr double pace = 1.3;
  constexpr double farthest = 1e3;  // from the prediction, as a factor
  const double predicted = trial.predicted();
  double low = predicted;
  while (trial.grows(low) && low * farthest > predicted) low /= pace;
  double high = pace * low;
  while (high < farthest * predicted && !trial.grows(high)) {
    low = high;
    high *= pace;
  }
  if (low * farthest <= predicted || high >= farthest * predicted) {
    throw NumericalError("no limit of the explicit step within a factor of 1000 of " +
                         std::to_string(predicted) + " s: is all of the tissue held?");
  }
  while (high > (1 + limit_accuracy) * low) {
    const double middle = std::sqrt(low * high);
    (trial.grows(middle) ? high : low) = middle;
  }
  return {predicted, std::sqrt(low * high)};
}

EnergyGrowth energy_growth(TissueOperator& tissue,
                           const Mesh& mesh,
                           const ConstraintSet& constraints,
                           Vec velocities,
                           const TimeParameters& time,
                           double h,
                           int n_steps) {
  ImplicitNewmark integrator(tissue, mesh, time);
  State state = at_rest(tissue);
  check(VecCopy(velocities, state.v.get()));
  OwnedVec load = tissue.make_vector();
  check(VecSet(load.get(), 0));
  OwnedVec work = tissue.make_vector();
  const double start = kinetic_energy(tissue, state.v.get(), work.get());
  EnergyGrowth growth;
  for (int n = 0; n < n_steps; ++n) {
    take_step(integrator, state, load.get(), h, constraints);
    const StoredEnergy stored = integrator.energy(state);
    growth.last = (stored.kinetic + stored.strain) / start;
    growth.largest = std::max(growth.largest, growth.last);
    constexpr double solver_noise = 1e-6;
    if (2 * n >= n_steps && !(growth.last <= 1 + solver_noise)) growth.grows = true;
  }
  return growth;
}

}  // namespace stylet
