// Steps of ImplicitNewmark in the near field.
#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>

namespace stylet {

// Predictors of what became near.
void ImplicitNewmark::refresh_near() {
  const Vec vectors[2] = {u_guess_.get(), v_guess_.get()};
  if (near_.coordinates().size() == u_near_.size()) return;
  const auto values = near_.values(vectors, u_near_.size());
  u_near_.insert(u_near_.end(), values[0].begin(), values[0].end());
  v_near_.insert(v_near_.end(), values[1].begin(), values[1].end());
  change_.resize(near_.coordinates().size(), 0.0);
  if (!rows_.has_track()) return;
  const Vec starts[1] = {state_->u.get()};
  const auto start = near_.values(starts, start_.size())[0];
  for (const double tissue : start) {
    const std::size_t at = start_.size();
    start_.push_back(near_.is_row(at) ? tissue + rows_.rest_of(near_.coordinates()[at]) : 0);
  }
}

RowTrial ImplicitNewmark::row(int coordinate) const {
  const std::size_t at = near_.at(coordinate);
  const double u = u_near_[at] + solution_.x[at];
  return {start_[at], u, (u - start_[at]) / h_, solution_.reaction[at]};
}

void ImplicitNewmark::watch(std::span<const int> coordinates) {
  watched_.assign(coordinates.begin(), coordinates.end());
  if (!fresh_) near_.include(watched_);  // else once the operator is made
}

// Predictors, right-hand side and operator at the nodes whose rows changed; the same as `predict`
// would give.
void ImplicitNewmark::predict_edited() {
  static const LogEvent event("StyletPredict");
  const LogScope scope(event);
  const std::vector<int> dofs = stylet::dofs_of(edited_);
  const double c0 = h_ * h_ * k_.c0;
  {
    const Values u0(state_->u.get());
    const Values v0(state_->v.get());
    const Values a0(state_->a.get());
    for (const int dof : dofs) {
      const bool own = u0.owns(dof);
      const double u = own ? u0[dof] : 0;
      const double v = own ? v0[dof] : 0;
      const double a = own ? a0[dof] : 0;
      set_owned(u_guess_.get(), dof, u + h_ * v + c0 * a);
      set_owned(v_guess_.get(), dof, v + h_ * k_.g0 * a);
    }
  }
  near_.changed(tissue_.tangent_matrix(), dofs);
  refresh_near();
  const std::vector<int> columns = stylet::dofs_of(surrounding_);
  const bool by_products = keeps_products();
  if (by_products) products_.require(cells_, *state_);
  const Vec vectors[4] = {u_guess_.get(), v_guess_.get(), state_->a.get(), held_increment_.get()};
  const auto values = gather(vectors, columns);
  const auto damping = tissue_.damping().value_or(RayleighDamping{});
  std::vector<double> stretched = values[0];
  std::vector<double> moved = values[2];
  for (std::size_t i = 0; i < columns.size(); ++i) {
    stretched[i] += damping.stiffness_factor * values[1][i];
    moved[i] = k_.alpha_m * moved[i] + damping.mass_factor * values[1][i];
  }
  std::vector<double> change(dofs.size(), 0.0);
  {
    const Values load(load_);
    const Values base(rhs_base_.get());
    const Values ku(products_.ku());
    const Values kv(products_.kv());
    const Values mv(products_.mv());
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      if (!load.owns(dofs[i])) continue;
      double rhs = load[dofs[i]];
      if (by_products) {
        rhs -= ku[dofs[i]] + (h_ + damping.stiffness_factor) * kv[dofs[i]] +
               damping.mass_factor * mv[dofs[i]];
      } else {
        rhs -= row_product(tissue_.stiffness(), dofs[i], columns, stretched);
      }
      if (!by_products && (k_.alpha_m != 0 || damping.mass_factor != 0)) {
        if (tissue_.mass() != nullptr) {
          rhs -= row_product(tissue_.mass(), dofs[i], columns, moved);
        } else {
          const auto at = std::ranges::lower_bound(columns, dofs[i]) - columns.begin();
          rhs -= Values(tissue_.lumped_mass())[dofs[i]] * moved[static_cast<std::size_t>(at)];
        }
      }
      if (held_move_) rhs -= row_product(tissue_.tangent_matrix(), dofs[i], columns, values[3]);
      change[i] = rhs - base[dofs[i]];
    }
  }
  if (size_of(tissue_.comm()) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, change.data(), static_cast<int>(change.size()), MPI_DOUBLE, MPI_SUM,
                  tissue_.comm());
  }
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    if (near_.eliminated(dofs[i])) continue;
    const std::size_t at = near_.at(dofs[i]);
    const auto from =
        static_cast<std::size_t>(std::ranges::lower_bound(columns, dofs[i]) - columns.begin());
    u_near_[at] = values[0][from];
    v_near_[at] = values[1][from];
    change_[at] = change[i];
  }
  edited_.clear();
}

Trial ImplicitNewmark::attempt_near(const ConstraintSet& constraints) {
  near_.include(dofs_of(constraints));
  refresh_near();
  push(constraints, change_);
  demand_.given.clear();
  for (const auto& c : constraints.dofs) {
    const std::size_t at = near_.at(c.dof);
    const bool by_step = near_.is_row(at) && c.velocity;
    demand_.given.push_back({at, by_step ? start_[at] + h_ * c.value - u_near_[at]
                                         : increment_of(c, u_near_[at], v_near_[at])});
  }
  std::vector<double> speeds = v_near_;
  for (std::size_t i = 0; i < start_.size(); ++i) {
    if (near_.is_row(i)) speeds[i] = (u_near_[i] - start_[i]) / h_;
  }
  damp(constraints, speed(), speeds);
  demand_.weights.clear();
  demand_.value = 0;
  demand_.rest = constraints.mean ? constraints.mean->rest : 0;
  if (constraints.mean) {
    double u = 0;
    double moved = 0;  // by held dofs
    for (const auto& [dof, weight] : constraints.mean->weights) {
      if (near_.eliminated(dof)) {
        const Vec vectors[2] = {u_guess_.get(), held_increment_.get()};
        const int one[1] = {dof};
        const auto held = gather(vectors, one);
        u += weight * held[0][0];
        moved += weight * held[1][0];
        continue;
      }
      demand_.weights.push_back({near_.at(dof), weight});
      u += weight * u_near_[demand_.weights.back().at];
    }
    demand_.value = constraints.mean->value - u - moved;
    if (demand_.weights.empty()) throw_all_held();
  }
  solution_ = near_.solve(extra_, demand_);
  return near_trial([&](std::size_t i) { return u_near_[i] + solution_.x[i]; },
                    [&](std::size_t i) { return v_near_[i] + speed() * solution_.x[i]; });
}

// The last trial at all dofs.
void ImplicitNewmark::complete_near() {
  const auto left = [&](Vec x, Vec residual) {
    keeps_products() ? balance_by_products(x, residual) : balance(x, residual);
  };
  near_.complete(left, largest_, extra_, demand_, solution_, increment_.get(), work_.get());
  collect_reactions(work_.get());
  if (held_move_) check(VecAXPY(increment_.get(), 1, held_increment_.get()));
  if (keeps_products()) return;  // u_ and v_ are of the last balance
  check(VecWAXPY(u_.get(), 1, increment_.get(), u_guess_.get()));
  check(VecWAXPY(v_.get(), speed(), increment_.get(), v_guess_.get()));
}

void ImplicitNewmark::balance(Vec x, Vec residual) {
  cells_.stiffness_and_mass(x, x, residual, u_.get());
  check(VecAXPBYPCZ(residual, operator_.mass, -1, operator_.stiffness, u_.get(), rhs_base_.get()));
  take_extra(residual, extra_);
}

// Backward Euler: what the end of the step leaves of the balance of forces, which is the same.
void ImplicitNewmark::balance_by_products(Vec x, Vec residual) {
  const double h = h_;
  {
    const Values increment(x);
    const Values of_held(held_increment_.get());
    const Values u_guess(u_guess_.get());
    const Values v_guess(v_guess_.get());
    Entries u(u_.get());
    Entries v(v_.get());
    for (std::size_t i = 0; i < n_owned_; ++i) {
      const double more = increment.data()[i] + of_held.data()[i];
      u.data()[i] = u_guess.data()[i] + more;
      v.data()[i] = v_guess.data()[i] + more / h;
    }
  }
  cells_.stiffness_and_mass(u_.get(), v_.get(), products_.next_ku(), products_.next_mv());
  const auto damping = tissue_.damping().value_or(RayleighDamping{});
  // A difference of K u over a much shorter step than the damping's time would be round-off.
  constexpr double much = 1e3;
  if (damping.stiffness_factor > much * h) {
    cells_.stiffness(v_.get(), products_.next_kv());
  } else {
    check(VecWAXPY(products_.next_kv(), -1, products_.ku(), products_.next_ku()));
    check(VecScale(products_.next_kv(), 1 / h));
  }
  const double stiffness_factor = damping.stiffness_factor;
  const double mass_damped = damping.mass_factor;
  const Values mv0(products_.mv());
  const Values ku1(products_.next_ku());
  const Values kv1(products_.next_kv());
  const Values mv1(products_.next_mv());
  const Values load(load_);
  {
    Entries r(residual);
    for (std::size_t i = 0; i < n_owned_; ++i) {
      const double mv = mv1.data()[i];
      r.data()[i] = (mv - mv0.data()[i]) / h + mass_damped * mv + ku1.data()[i] +
                    stiffness_factor * kv1.data()[i] - load.data()[i];
    }
  }
  // The change of the right-hand side by edits is in the products.
  std::vector<double> forces = extra_;
  for (std::size_t i = 0; i < forces.size(); ++i) forces[i] -= change_[i];
  take_extra(residual, forces);
}

// What damping took in this step, and with backward Euler the energies of its end: other schemes may
// still fit velocities to given motion.
void ImplicitNewmark::store_energy() {
  const auto damping = tissue_.damping().value_or(RayleighDamping{});
  double sums[4] = {0, 0, 0, 0};  // u K u, v M v, and increment K increment, increment M increment
  if (keeps_products()) {
    const Values u(u_.get());
    const Values v(v_.get());
    const Values u0(state_->u.get());
    const Values ku(products_.next_ku());
    const Values mv(products_.next_mv());
    const Values ku0(products_.ku());
    for (std::size_t i = 0; i < n_owned_; ++i) {
      const double moved = u.data()[i] - u0.data()[i];
      sums[0] += u.data()[i] * ku.data()[i];
      sums[1] += v.data()[i] * mv.data()[i];
      sums[2] += moved * (ku.data()[i] - ku0.data()[i]);
      sums[3] += moved * h_ * mv.data()[i];
    }
  } else if (tissue_.damping()) {
    Vec increment = rhs_.get();
    check(VecWAXPY(increment, -1, state_->u.get(), u_.get()));
    cells_.stiffness_and_mass(increment, increment, products_.ku(), products_.mv());
    const Values moved(increment);
    const Values k(products_.ku());
    const Values m(products_.mv());
    for (std::size_t i = 0; i < n_owned_; ++i) {
      sums[2] += moved.data()[i] * k.data()[i];
      sums[3] += moved.data()[i] * m.data()[i];
    }
  }
  if (size_of(tissue_.comm()) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, tissue_.comm());
  }
  stored_ = {0.5 * sums[1], 0.5 * sums[0]};
  trial_.damping_work = (damping.stiffness_factor * sums[2] + damping.mass_factor * sums[3]) / h_;
}

Trial ImplicitNewmark::finish(bool) {
  complete_near();
  trial_ = at_end(u_.get(), v_.get(), {reaction_.get(), solution_.lambda});
  trial_.end_weight = end_weight();
  if (has_blow_) settle();
  store_energy();
  return trial_;
}

}  // namespace stylet
