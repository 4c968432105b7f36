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
    : CondensedIntegrator(tissue),
      scheme_(coefficients(parameters.scheme, parameters.rho_infinity)),
      k_(scheme_) {
  for (OwnedVec* vec : {&u_guess_, &v_guess_, &increment_, &held_increment_, &rhs_base_}) {
    *vec = tissue.make_vector();
    check(VecSet(vec->get(), 0));
  }
}

void ImplicitNewmark::touched(const Mesh& mesh, std::span<const int> cells) {
  CondensedIntegrator::touched(mesh, cells);
  surrounding_ = tissue_.coupled(mesh, edited_);
}

void ImplicitNewmark::begin(State& state, Vec load, double h, std::span<const PrescribedDof> held) {
  state_ = &state;
  load_ = load;
  step_ = h;
  held_.assign(held.begin(), held.end());
  fresh_ = true;
  twice_ = false;
  k_ = scheme_;
  h_ = h;
  from_ = {state.u.get(), state.v.get(), state.a.get()};
}

// The operator of the present coefficients, with all edits.
void ImplicitNewmark::make_operator() {
  const double shift_v = k_.g1 / (k_.c1 * h_);
  const double shift_a = (1 - k_.alpha_m) / (k_.c1 * h_ * h_);
  if (shift_v != shift_v_ || shift_a != shift_a_) {
    tissue_.make_tangent(tissue_.tangent(shift_v, shift_a));
    near_.forget();
  }
  shift_v_ = shift_v;
  shift_a_ = shift_a;
  if (near_.wants_factor()) {
    near_.factor(tissue_.tangent_matrix(), held_);
  } else if (!edited_.empty()) {
    near_.changed(tissue_.tangent_matrix(), stylet::dofs_of(edited_));
  }
  edited_.clear();
}

// What held dofs take of the right-hand side, and the near field's solution for what is left.
void ImplicitNewmark::prepare() {
  make_operator();
  if (held_move_) {
    check(MatMult(tissue_.tangent_matrix(), held_increment_.get(), work_.get()));
    check(VecAXPY(rhs_base_.get(), -1, work_.get()));
  }
  check(VecCopy(rhs_base_.get(), rhs_.get()));
  for (const auto& c : held_) set_owned(rhs_.get(), c.dof, 0);
  near_.load(rhs_.get());
  u_near_.clear();
  v_near_.clear();
  change_.clear();
  near_.include(watched_);
  refresh_near();
}

// Predictors from the start, the forces that they leave unbalanced, and increments of held dofs.
void ImplicitNewmark::predict() {
  const auto [u0, v0, a0] = from_;
  check(VecCopy(u0, u_guess_.get()));
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
  return c.velocity ? (c.value - v) / speed() : place(c.value, u, v) - u;
}

// Where a displacement that ends at `end` is at the end of this stage; u, v: its predictors.
double ImplicitNewmark::place(double end, double u, double v) const {
  // Half-way, with the velocity of the whole step. Backward Euler predicts by u0 + h v0, v0.
  return halfway_ ? 0.5 * (end + u - h_ * v) : end;
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
  held_begin_ = size[0] > at_once * h_ * fastest_;
}

Trial ImplicitNewmark::attempt(const ConstraintSet& constraints, bool) {
  if (fresh_) {
    predict();
  } else if (!twice_ && !edited_.empty()) {
    predict_edited();
  }
  // It needs the predictors of the whole step, which two half steps leave.
  const bool begins = twice_ || held_begin_ || needle_begins(constraints);
  if (!damps_at_once() && (begins || constraints.load_jumps)) {
    twice_ = true;
    trial_ = attempt_twice(constraints);
  } else {
    if (fresh_) prepare();
    trial_ = attempt_near(constraints);
    has_blow_ = begins;
    if (has_blow_) take_off_blow(constraints);
  }
  trial_.iterations = near_.take_iterations();
  fresh_ = false;
  return trial_;
}

void ImplicitNewmark::accept() {
  if (!twice_ && !damps_at_once()) fit_given();
  check(VecCopy(u_.get(), state_->u.get()));
  check(VecCopy(v_.get(), state_->v.get()));
  check(VecCopy(increment_.get(), state_->a.get()));
  check(VecScale(state_->a.get(), 1 / (k_.c1 * h_ * h_)));
  state_->t += step_;
  released_ = had_mean_ && !has_mean_;
  had_mean_ = has_mean_;
}

}  // namespace stylet
