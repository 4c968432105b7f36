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
      scheme_(coefficients(inertia_ ? parameters.scheme : ImplicitScheme::backward_euler,
                           parameters.rho_infinity)),
      k_(scheme_) {
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
  return damped_steps_ > 0 ? half_ : std::numeric_limits<double>::infinity();
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
  held_.assign(held.begin(), held.end());
  fresh_ = true;
  k_ = damped_steps_ > 0 ? coefficients(ImplicitScheme::backward_euler, 0) : scheme_;
  h_ = h;
}

// The operator of the present coefficients, with all edits.
void ImplicitNewmark::make_operator() {
  const double shift_v = k_.g1 / (k_.c1 * h_);
  const double shift_a = (1 - k_.alpha_m) / (k_.c1 * h_ * h_);
  const bool anew = inertia_ ? shift_v != shift_v_ || shift_a != shift_a_ : shift_a_ == 0;
  if (anew) {
    tissue_.make_tangent(inertia_ ? tissue_.tangent(shift_v, shift_a) : Combination{0, 1});
    near_ ? near_->forget() : solver_->forget();
  }
  shift_v_ = shift_v;
  shift_a_ = shift_a;
  if (!near_) return;
  if (near_->wants_factor()) {
    near_->factor(tissue_.tangent_matrix(), held_);
  } else if (!edited_.empty()) {
    near_->changed(tissue_.tangent_matrix(), dofs_of(edited_));
  }
  edited_.clear();
}

// What held dofs take of the right-hand side, and the near field's solution for what is left.
void ImplicitNewmark::prepare() {
  make_operator();
  if (!near_) return;
  if (held_move_) {
    check(MatMult(tissue_.tangent_matrix(), held_increment_.get(), work_.get()));
    check(VecAXPY(rhs_base_.get(), -1, work_.get()));
  }
  check(VecCopy(rhs_base_.get(), rhs_.get()));
  for (const auto& c : held_) set_owned(rhs_.get(), c.dof, 0);
  near_->load(rhs_.get());
  u_near_.clear();
  v_near_.clear();
  change_.clear();
  near_->include(watched_);
  refresh_near();
}

// Predictors from the start, the forces that they leave unbalanced, and increments of held dofs.
void ImplicitNewmark::predict() {
  const Vec u0 = state_->u.get();
  const Vec v0 = state_->v.get();
  const Vec a0 = state_->a.get();
  check(VecCopy(u0, u_guess_.get()));
  if (!inertia_) {
    check(VecSet(v_guess_.get(), 0));
    check(MatMult(tissue_.stiffness(), u_guess_.get(), work_.get()));
    check(VecWAXPY(rhs_base_.get(), -1, work_.get(), load_));
    hold();
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
  hold();
}

// The unknown that gives a dof its displacement or velocity; u, v: its predictors.
double ImplicitNewmark::increment_of(const PrescribedDof& c, double u, double v) const {
  return c.velocity ? (c.value - v) / speed() : c.value - u;
}

void ImplicitNewmark::hold() {
  const Values u(u_guess_.get());
  const Values v(v_guess_.get());
  double size[2] = {0, 0};  // increment, velocity
  for (const auto& c : held_) {
    if (!u.owns(c.dof)) continue;
    const double value = increment_of(c, u[c.dof], v[c.dof]);
    set_owned(held_increment_.get(), c.dof, value);
    size[0] = std::max(size[0], std::abs(value));
    size[1] = std::max(size[1], std::abs(v[c.dof] + speed() * value));
  }
  if (size_of(tissue_.comm()) > 1) {
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, size, 2, MPI_DOUBLE, MPI_MAX, tissue_.comm()));
  }
  held_move_ = size[0] != 0;
  fastest_ = std::max(fastest_, size[1]);
  held_begin_ = inertia_ && size[0] > at_once * h_ * fastest_;
}

Trial ImplicitNewmark::attempt(const ConstraintSet& constraints, bool edited) {
  if (fresh_) {
    predict();
  } else if (near_ && !edited_.empty()) {
    predict_edited();
  } else if (!near_ && edited) {
    predict();
  }
  const bool begins = held_begin_ || needle_begins(constraints);
  if (scheme_.c0 != 0 && (begins || (inertia_ && constraints.load_jumps))) {
    const bool is_damped = damps_at_once();
    if (!is_damped) half_ = 0.5 * h_;
    damped_steps_ = 2;
    if (!is_damped) return trial_;
  }
  if (fresh_) prepare();
  trial_ = near_ ? attempt_near(constraints) : attempt_whole(constraints);
  has_blow_ = begins;
  if (has_blow_) take_off_blow(constraints);
  trial_.only_end = inertia_ && damps_at_once();
  fresh_ = false;
  return trial_;
}

Trial ImplicitNewmark::attempt_whole(const ConstraintSet& constraints) {
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
      double before = 0;  // of the predictors
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
  if (!damps_at_once()) fit_given();
  check(VecCopy(u_.get(), state_->u.get()));
  check(VecCopy(v_.get(), state_->v.get()));
  if (inertia_) {
    check(VecCopy(increment_.get(), state_->a.get()));
    check(VecScale(state_->a.get(), 1 / (k_.c1 * h_ * h_)));
  }
  state_->t += h_;
  if (damped_steps_ > 0) --damped_steps_;
  released_ = had_mean_ && !has_mean_;
  had_mean_ = has_mean_;
}

}  // namespace stylet
