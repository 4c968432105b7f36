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

ImplicitNewmark::ImplicitNewmark(TissueOperator& tissue,
                                 const Mesh& mesh,
                                 const TimeParameters& parameters)
    : CondensedIntegrator(tissue, mesh),
      scheme_(coefficients(parameters.scheme, parameters.rho_infinity)),
      k_(scheme_),
      products_(tissue),
      n_owned_(static_cast<std::size_t>(tissue.end_dof() - tissue.first_dof())) {
  for (OwnedVec* vec : {&u_guess_, &v_guess_, &increment_, &held_increment_, &rhs_base_}) {
    *vec = tissue.make_vector();
    check(VecSet(vec->get(), 0));
  }
}

void ImplicitNewmark::touched(const Mesh& mesh, std::span<const int> cells) {
  CondensedIntegrator::touched(mesh, cells);
  surrounding_ = tissue_.coupled(mesh, edited_);
  if (state_ == nullptr || !keeps_products()) return;
  const auto rows = tissue_.rows_of(mesh, cells);
  products_.edited(tissue_, *state_, rows, tissue_.coupled(mesh, rows));
}

void ImplicitNewmark::renewed(const Mesh& mesh) {
  CondensedIntegrator::renewed(mesh);
  products_.forget();
  shift_v_ = shift_a_ = 0;  // of no step
}

void ImplicitNewmark::leave_track() {
  CondensedIntegrator::leave_track();
  watched_.clear();
}

// Comes before an edit: what is edited then are the products of this state.
void ImplicitNewmark::complete_at(std::span<const int>) {
  if (state_ != nullptr) products_.compare(*state_);
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
  if (shift_v != shift_v_ || shift_a != shift_a_) {
    operator_ = tissue_.tangent(shift_v, shift_a);
    tissue_.make_tangent(operator_);
    near_.forget();
  }
  shift_v_ = shift_v;
  shift_a_ = shift_a;
  if (near_.wants_factor()) {
    near_.factor(tissue_.tangent_matrix(), held_, [&] { return tissue_.saddle(operator_); });
  } else if (!edited_.empty()) {
    near_.changed(tissue_.tangent_matrix(), stylet::dofs_of(edited_));
  }
  edited_.clear();
}

// What held dofs take of the right-hand side, and the near field's solution for what is left.
void ImplicitNewmark::prepare() {
  make_operator();
  if (held_move_) {
    cells_.stiffness_and_mass(held_increment_.get(), held_increment_.get(), work_.get(),
                              rhs_.get());
    check(VecAXPY(rhs_base_.get(), -operator_.stiffness, work_.get()));
    check(VecAXPY(rhs_base_.get(), -operator_.mass, rhs_.get()));
  }
  check(VecCopy(rhs_base_.get(), rhs_.get()));
  {
    Entries rhs(rhs_.get());
    for (const auto& c : held_) {
      if (rhs.owns(c.dof)) rhs[c.dof] = 0;
    }
  }
  check(VecNorm(rhs_base_.get(), NORM_INFINITY, &largest_));
  near_.load(rhs_.get());
  u_near_.clear();
  v_near_.clear();
  change_.clear();
  start_.clear();
  near_.include(watched_);
  refresh_near();
}

// Predictors from the start, the forces that they leave unbalanced, and increments of held dofs.
void ImplicitNewmark::predict() {
  if (keeps_products()) {
    predict_by_products();
    hold();
    return;
  }
  const auto damping = tissue_.damping().value_or(RayleighDamping{});
  const bool with_mass = k_.alpha_m != 0 || damping.mass_factor != 0;
  {
    const Values u0(state_->u.get());
    const Values v0(state_->v.get());
    const Values a0(state_->a.get());
    Entries u(u_guess_.get());
    Entries v(v_guess_.get());
    Entries stretched(work_.get());
    Entries moved(rhs_.get());
    const double of_a = h_ * h_ * k_.c0;
    const double of_v = h_ * k_.g0;
    for (std::size_t i = 0; i < n_owned_; ++i) {
      const double speed = v0.data()[i] + of_v * a0.data()[i];
      const double place = u0.data()[i] + h_ * v0.data()[i] + of_a * a0.data()[i];
      u.data()[i] = place;
      v.data()[i] = speed;
      stretched.data()[i] = place + damping.stiffness_factor * speed;
      if (with_mass) moved.data()[i] = k_.alpha_m * a0.data()[i] + damping.mass_factor * speed;
    }
  }
  // K (u + stiffness_factor v) + M (alpha_m a0 + mass_factor v)
  if (with_mass) {
    cells_.stiffness_and_mass(work_.get(), rhs_.get(), rhs_base_.get(), reaction_.get());
    check(VecAXPBYPCZ(rhs_base_.get(), 1, -1, -1, load_, reaction_.get()));
  } else {
    cells_.stiffness(work_.get(), rhs_base_.get());
    check(VecAYPX(rhs_base_.get(), -1, load_));
  }
  hold();
}

// The same for backward Euler, without a product.
void ImplicitNewmark::predict_by_products() {
  products_.require(cells_, *state_);
  const auto damping = tissue_.damping().value_or(RayleighDamping{});
  const double stretch = h_ + damping.stiffness_factor;
  const Values u0(state_->u.get());
  const Values v0(state_->v.get());
  const Values ku(products_.ku());
  const Values kv(products_.kv());
  const Values mv(products_.mv());
  const Values load(load_);
  Entries u(u_guess_.get());
  Entries v(v_guess_.get());
  Entries rhs(rhs_base_.get());
  const double h = h_;
  const double mass_factor = damping.mass_factor;
  for (std::size_t i = 0; i < n_owned_; ++i) {
    const double speed = v0.data()[i];
    u.data()[i] = u0.data()[i] + h * speed;
    v.data()[i] = speed;
    rhs.data()[i] =
        load.data()[i] - ku.data()[i] - stretch * kv.data()[i] - mass_factor * mv.data()[i];
  }
}

// The unknown that gives a dof its displacement or velocity; u, v: its predictors.
double ImplicitNewmark::increment_of(const PrescribedDof& c, double u, double v) const {
  return c.velocity ? (c.value - v) / speed() : c.value - u;
}

void ImplicitNewmark::hold() {
  const Values u(u_guess_.get());
  const Values v(v_guess_.get());
  Entries increment(held_increment_.get());
  double size[2] = {0, 0};  // increment, velocity
  for (const auto& c : held_) {
    if (!u.owns(c.dof)) continue;
    const double value = increment_of(c, u[c.dof], v[c.dof]);
    increment[c.dof] = value;
    size[0] = std::max(size[0], std::abs(value));
    size[1] = std::max(size[1], std::abs(v[c.dof] + speed() * value));
  }
  if (size_of(tissue_.comm()) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, size, 2, MPI_DOUBLE, MPI_MAX, tissue_.comm());
  }
  held_move_ = size[0] != 0;
  fastest_ = std::max(fastest_, size[1]);
  held_begin_ = size[0] > at_once * h_ * fastest_;
}

Trial ImplicitNewmark::attempt(const ConstraintSet& constraints, bool) {
  if (fresh_) {
    predict();
  } else if (!edited_.empty()) {
    predict_edited();
  }
  const bool begins = held_begin_ || (!rows_.has_track() && needle_begins(constraints));
  if (scheme_.c0 != 0 && (begins || constraints.load_jumps)) {
    const bool is_damped = damps_at_once();
    if (!is_damped) half_ = 0.5 * h_;
    damped_steps_ = 2;
    if (!is_damped) return trial_;
  }
  if (fresh_) prepare();
  trial_ = attempt_near(constraints);
  has_blow_ = begins;
  if (has_blow_) take_off_blow(!rows_.has_track() ? constraints : ConstraintSet{});
  trial_.end_weight = end_weight();
  trial_.iterations = near_.take_iterations();
  fresh_ = false;
  return trial_;
}

EnergyRules ImplicitNewmark::energy_rules() const {
  EnergyRules rules;
  rules.advice = keeps_products()
                     ? "a smaller time.step, or a finer mesh"
                     : "a smaller time.step, or time.scheme backward_euler, which damps waves";
  return rules;
}

void ImplicitNewmark::accept() {
  if (!damps_at_once() && !rows_.has_track()) fit_given();
  rows_.keep(near_, extra_, demand_, solution_);
  check(VecCopy(u_.get(), state_->u.get()));
  check(VecCopy(v_.get(), state_->v.get()));
  {
    const Values increment(increment_.get());
    Entries a(state_->a.get());
    const double factor = 1 / (k_.c1 * h_ * h_);
    for (std::size_t i = 0; i < n_owned_; ++i) a.data()[i] = factor * increment.data()[i];
  }
  if (keeps_products()) {
    products_.swap();
    products_.brought_to(*state_);
    stored_.strain += rows_.energy();
    stored_of_ = StateVersion(*state_);
  }
  state_->t += h_;
  if (damped_steps_ > 0) --damped_steps_;
  released_ = had_mean_ && !has_mean_;
  had_mean_ = has_mean_;
}

}  // namespace stylet
