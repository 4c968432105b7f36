#include "stylet/dynamics/implicit_newmark.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/base/text.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stylet {

StepCoefficients coefficients(ImplicitScheme scheme, double rho_infinity) {
  switch (scheme) {
    case ImplicitScheme::average_acceleration:
      return {0, 0.25, 0.25, 0.5, 0.5};
    case ImplicitScheme::backward_euler:
      return {0, 0, 1, 0, 1};
    case ImplicitScheme::generalised_alpha:
      break;
  }
  const double alpha_m = (rho_infinity - 1) / (rho_infinity + 1);
  const double gamma = 0.5 - alpha_m;
  const double beta = 0.25 * (1 - alpha_m) * (1 - alpha_m);
  return {alpha_m, 0.5 - beta, beta, 1 - gamma, gamma};
}

ImplicitNewmark::ImplicitNewmark(TissueOperator& tissue, const TimeParameters& parameters)
    : tissue_(tissue),
      inertia_(parameters.method != TimeMethod::quasi_static),
      k_(coefficients(parameters.scheme, parameters.rho_infinity)) {
  if (!inertia_) k_ = {0, 0, 1, 0, 1};
  if (NearField::serves(tissue.comm(), tissue.n_dofs())) {
    near_.emplace(tissue.comm(), tissue.n_dofs());
  } else {
    solver_.emplace(tissue.comm());
  }
  for (OwnedVec* vec : {&u_, &v_, &u_guess_, &v_guess_, &increment_, &held_increment_, &rhs_,
                        &rhs_base_, &reaction_, &work_}) {
    *vec = tissue.make_vector();
    check(VecSet(vec->get(), 0));
  }
}

double ImplicitNewmark::stable_step() const {
  return std::numeric_limits<double>::infinity();
}

void ImplicitNewmark::touched(const Mesh& mesh, std::span<const int> cells) {
  if (!near_) return;
  const auto rows = tissue_.rows_of(mesh, cells);
  edited_.insert(edited_.end(), rows.begin(), rows.end());
  sort_unique(edited_);
  surrounding_ = tissue_.coupled(mesh, edited_);
}

void ImplicitNewmark::begin(State& state, Vec load, double h, std::span<const PrescribedDof> held) {
  state_ = &state;
  load_ = load;
  h_ = h;
  held_.assign(held.begin(), held.end());
  const bool anew = inertia_ ? h != operator_h_ : operator_h_ == 0;
  if (anew) {
    tissue_.make_tangent(
        inertia_ ? tissue_.tangent(k_.g1 / (k_.c1 * h), (1 - k_.alpha_m) / (k_.c1 * h * h))
                 : Combination{0, 1});
    near_ ? near_->forget() : solver_->forget();
  }
  operator_h_ = h;
  predict();
  if (!near_) return;
  hold();
  Mat a = tissue_.tangent_matrix();
  if (near_->wants_factor()) {
    near_->factor(a, held);
  } else if (!edited_.empty()) {
    near_->changed(a, dofs_of(edited_));
  }
  edited_.clear();
  check(VecCopy(rhs_base_.get(), rhs_.get()));
  for (const auto& c : held_) set_owned(rhs_.get(), c.dof, 0);
  near_->load(rhs_.get());
  u_near_.clear();
  v_near_.clear();
  change_.clear();
  refresh_near();
}

// Predictors from the state as it is now, and the forces that they leave unbalanced.
void ImplicitNewmark::predict() {
  const Vec u0 = state_->u.get();
  const Vec v0 = state_->v.get();
  const Vec a0 = state_->a.get();
  check(VecCopy(u0, u_guess_.get()));
  if (!inertia_) {
    check(VecSet(v_guess_.get(), 0));
    check(MatMult(tissue_.stiffness(), u_guess_.get(), work_.get()));
    check(VecWAXPY(rhs_base_.get(), -1, work_.get(), load_));
    return;
  }
  check(VecAXPY(u_guess_.get(), h_, v0));
  check(VecAXPY(u_guess_.get(), h_ * h_ * k_.c0, a0));
  check(VecWAXPY(v_guess_.get(), h_ * k_.g0, a0, v0));
  const auto damping = tissue_.damping().value_or(RayleighDamping{});
  // K (u + stiffness_factor v)
  check(VecWAXPY(work_.get(), damping.stiffness_factor, v_guess_.get(), u_guess_.get()));
  check(MatMult(tissue_.stiffness(), work_.get(), rhs_base_.get()));
  // M (alpha_m a0 + mass_factor v)
  if (k_.alpha_m != 0 || damping.mass_factor != 0) {
    check(VecCopy(a0, work_.get()));
    check(VecScale(work_.get(), k_.alpha_m));
    check(VecAXPY(work_.get(), damping.mass_factor, v_guess_.get()));
    tissue_.apply_mass(work_.get(), reaction_.get());
    check(VecAXPY(rhs_base_.get(), 1, reaction_.get()));
  }
  check(VecAYPX(rhs_base_.get(), -1, load_));
}

// The unknown that gives a dof its displacement or velocity; u, v: its predictors.
double ImplicitNewmark::increment_of(const PrescribedDof& c, double u, double v) const {
  return c.velocity ? (c.value - v) / speed() : c.value - u;
}

// Increments of held dofs, and what they take of the right-hand side.
void ImplicitNewmark::hold() {
  const Values u(u_guess_.get());
  const Values v(v_guess_.get());
  int moves = 0;
  for (const auto& c : held_) {
    if (!u.owns(c.dof)) continue;
    const double value = increment_of(c, u[c.dof], v[c.dof]);
    if (value != 0) moves = 1;
    set_owned(held_increment_.get(), c.dof, value);
  }
  if (size_of(tissue_.comm()) > 1) {
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &moves, 1, MPI_INT, MPI_MAX, tissue_.comm()));
  }
  held_move_ = moves != 0;
  if (!held_move_) return;
  check(MatMult(tissue_.tangent_matrix(), held_increment_.get(), work_.get()));
  check(VecAXPY(rhs_base_.get(), -1, work_.get()));
}

Trial ImplicitNewmark::attempt(const ConstraintSet& constraints, bool edited) {
  trial_ = near_ ? attempt_near(constraints) : attempt_whole(constraints, edited);
  return trial_;
}

Trial ImplicitNewmark::attempt_whole(const ConstraintSet& constraints, bool edited) {
  if (edited) predict();
  check(VecCopy(rhs_base_.get(), rhs_.get()));
  {
    Entries b(rhs_.get());
    for (const auto& [dof, force] : constraints.forces) {
      if (b.owns(dof)) b[dof] += force;
    }
  }
  // Given displacements and velocities as given increments.
  std::vector<DofValue> given;
  std::optional<MeanCondition> mean = constraints.mean;
  {
    const Values u(u_guess_.get());
    const Values v(v_guess_.get());
    const auto add = [&](const PrescribedDof& c) {
      given.push_back({c.dof, u.owns(c.dof) ? increment_of(c, u[c.dof], v[c.dof]) : 0});
    };
    std::ranges::for_each(held_, add);
    std::ranges::for_each(constraints.dofs, add);
    if (mean) {
      double before = 0;
      for (const auto& [dof, weight] : mean->weights) {
        if (u.owns(dof)) before += weight * u[dof];
      }
      if (size_of(tissue_.comm()) > 1) {
        check_mpi(MPI_Allreduce(MPI_IN_PLACE, &before, 1, MPI_DOUBLE, MPI_SUM, tissue_.comm()));
      }
      mean->value -= before;
    }
  }
  const auto result = solver_->solve(tissue_.tangent_matrix(), rhs_.get(), given,
                                     mean ? &*mean : nullptr, increment_.get(), reaction_.get());
  check(VecWAXPY(u_.get(), 1, increment_.get(), u_guess_.get()));
  check(VecWAXPY(v_.get(), speed(), increment_.get(), v_guess_.get()));
  Trial trial = at_end(u_.get(), v_.get(), {reaction_.get(), result.lambda});
  trial.iterations = result.iterations;
  return trial;
}

void ImplicitNewmark::accept() {
  check(VecCopy(u_.get(), state_->u.get()));
  check(VecCopy(v_.get(), state_->v.get()));
  if (inertia_) {
    check(VecCopy(increment_.get(), state_->a.get()));
    check(VecScale(state_->a.get(), 1 / (k_.c1 * h_ * h_)));
  }
  state_->t += h_;
}

}  // namespace stylet
