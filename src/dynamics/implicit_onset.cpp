// Steps of ImplicitNewmark in which given motion begins, changes its speed or ends.
#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

// Whether the needle gives tissue another velocity at once, or lets its tip go. Contacts that friction
// bounds give no blow.
bool ImplicitNewmark::needle_begins(const ConstraintSet& constraints) {
  needle_dofs_.assign(constraints.dofs.begin(), constraints.dofs.end());
  has_mean_ = constraints.mean.has_value();
  if (damps_at_once() && !has_mean_) return false;
  // Not in the step that lets go itself: its search for the advance needs a gap without jumps.
  if (fresh_ && released_ && !damps_at_once()) return true;
  std::vector<int> dofs;
  for (const auto& c : constraints.dofs) dofs.push_back(c.dof);
  if (has_mean_) {
    for (const auto& [dof, weight] : constraints.mean->weights) dofs.push_back(dof);
  }
  const Vec vectors[2] = {u_guess_.get(), v_guess_.get()};
  const auto guess = gather(vectors, dofs);
  double guided = 0;
  std::size_t i = 0;
  for (const auto& c : constraints.dofs) {
    const double x = increment_of(c, guess[0][i], guess[1][i]);
    fastest_ = std::max(fastest_, std::abs(guess[1][i] + speed() * x));
    if (!c.velocity && fresh_) guided = std::max(guided, std::abs(x));
    ++i;
  }
  double pushed = 0;
  if (has_mean_) {
    pushed = constraints.mean->value;
    for (const auto& [dof, weight] : constraints.mean->weights) pushed -= weight * guess[0][i++];
    fastest_ = std::max(fastest_, std::abs(constraints.mean->rate));
  }
  // Fields of nodes that edits move are interpolated: the needle takes them on to its axis, slowly. That is
  // looked at once a step, since the search for the advance needs a gap without jumps.
  constexpr double slow = 0.1;  // of the fastest so far
  if (!damps_at_once() && guided > slow * h_ * fastest_) return true;
  return std::abs(pushed) > at_once * h_ * fastest_;
}

// Given dofs go on with the mean velocity and acceleration of the step: what begins slowly, or is bounded
// by friction, is no onset, but must not alternate for ever either.
void ImplicitNewmark::fit_given() {
  const Values u0(state_->u.get());
  const Values v0(state_->v.get());
  const Values u1(u_.get());
  Entries v(v_.get());
  Entries increment(increment_.get());
  for (const auto& c : needle_dofs_) {
    if (!v.owns(c.dof)) continue;
    if (!c.velocity) v[c.dof] = (u1[c.dof] - u0[c.dof]) / h_;
    const double a = c.velocity ? (v[c.dof] - v0[c.dof]) / h_ : 0;
    increment[c.dof] = k_.c1 * h_ * h_ * a;
  }
}

// Backward Euler takes a blow at the start of the step as one more force over all of it; the motion is the
// same. The blow is what the mass alone needs to get the velocities of the step.
void ImplicitNewmark::take_off_blow(const ConstraintSet& constraints) {
  for (OwnedVec* vec : {&blow_, &jump_, &settled_}) {
    if (*vec) continue;
    *vec = tissue_.make_vector();
    check(VecSet(vec->get(), 0));
  }
  std::vector<DofValue> given;
  std::optional<MeanCondition> mean = constraints.mean;
  {
    std::vector<int> dofs;
    for (const auto& c : constraints.dofs) dofs.push_back(c.dof);
    if (mean) {
      for (const auto& [dof, weight] : mean->weights) dofs.push_back(dof);
    }
    const Vec vectors[1] = {u_guess_.get()};
    const auto u = gather(vectors, dofs)[0];
    const Values moved(held_increment_.get());
    for (const auto& c : held_) {
      given.push_back({c.dof, moved.owns(c.dof) ? moved[c.dof] / h_ : 0});
    }
    std::size_t i = 0;
    for (const auto& c : constraints.dofs) {
      if (!c.velocity) given.push_back({c.dof, (c.value - u[i]) / h_});
      ++i;
    }
    if (mean) {
      for (const auto& [dof, weight] : mean->weights) mean->value -= weight * u[i++];
      mean->value /= h_;
    }
  }
  if (tissue_.mass() != nullptr) {
    if (!mass_solver_) mass_solver_.emplace(tissue_.comm());
    check(VecSet(work_.get(), 0));
    blow_lambda_ = mass_solver_->solve(tissue_.mass(), work_.get(), given, mean ? &*mean : nullptr,
                                       jump_.get(), blow_.get());
  } else {
    blow_lumped(given, mean ? &*mean : nullptr);
  }
  settle();
}

void ImplicitNewmark::blow_lumped(std::span<const DofValue> given, const MeanCondition* mean) {
  check(VecSet(blow_.get(), 0));
  check(VecSet(jump_.get(), 0));
  Entries blow(blow_.get());
  Entries jump(jump_.get());
  const Values mass(tissue_.lumped_mass());
  for (const auto& [dof, value] : given) {
    if (!mass.owns(dof)) continue;
    jump[dof] = value;
    blow[dof] = mass[dof] * value;
  }
  blow_lambda_ = 0;
  if (mean == nullptr) return;
  double sums[2] = {0, 0};  // what given dofs reach, mobility of the others
  const auto is_given = [&](int dof) {
    return std::ranges::find(given, dof, &DofValue::dof) != given.end();
  };
  for (const auto& [dof, weight] : mean->weights) {
    if (!mass.owns(dof)) continue;
    sums[0] += weight * jump[dof];
    if (!is_given(dof)) sums[1] += weight * weight / mass[dof];
  }
  if (size_of(tissue_.comm()) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, tissue_.comm());
  }
  if (!(sums[1] > 0)) throw_all_held();
  blow_lambda_ = (mean->value - sums[0]) / sums[1];
  for (const auto& [dof, weight] : mean->weights) {
    if (mass.owns(dof) && is_given(dof)) blow[dof] -= blow_lambda_ * weight;
  }
}

// The forces without the blow.
void ImplicitNewmark::settle() {
  check(VecWAXPY(settled_.get(), -1 / h_, blow_.get(), trial_.needed.reaction));
  trial_.settled = {settled_.get(), trial_.needed.lambda - blow_lambda_ / h_};
}

}  // namespace stylet
