#include "stylet/dynamics/quasi_static.hpp"

#include "stylet/base/sorted.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"

#include <algorithm>

namespace stylet {

namespace {

double dot(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

QuasiStatic::QuasiStatic(TissueOperator& tissue, const Mesh& mesh)
    : CondensedIntegrator(tissue, mesh),
      held_u_(tissue.make_vector()),
      balanced_(tissue.make_vector()) {
  check(VecSet(held_u_.get(), 0));
}

void QuasiStatic::begin(State& state, Vec load, double h, std::span<const PrescribedDof> held) {
  state_ = &state;
  load_ = load;
  h_ = h;
  const auto same = [](const PrescribedDof& a, const PrescribedDof& b) {
    return a.dof == b.dof && a.value == b.value;
  };
  if (!std::ranges::equal(held, held_, same)) {
    fresh_ = true;
    held_.assign(held.begin(), held.end());
  }
  if (near_.wants_factor()) factor();
  if (!edited_.empty()) take_edits();
  load_tissue();
}

// Of the last trial, by forced dof.
std::vector<double> QuasiStatic::forces() const {
  if (!loaded_forces_.empty()) return loaded_forces_;
  std::vector<double> forces;
  const auto changed = near_.changed_forces(accepted_);
  for (const int dof : forced_) {
    const std::size_t at = near_.at(dof);
    forces.push_back(pushed_[at] + changed[at]);
  }
  return forces;
}

// Those forces stay known by making their dofs near again.
void QuasiStatic::factor() {
  complete();
  const std::vector<double> kept = forces();
  loaded_forces_.clear();
  near_.factor(tissue_.stiffness(), held_, [&] { return tissue_.saddle({0, 1}); });
  edited_.clear();
  start_.clear();
  accepted_.clear();
  pushed_.clear();
  last_pushed_.clear();
  make_near(forced_);
  for (std::size_t i = 0; i < forced_.size(); ++i) pushed_[near_.at(forced_[i])] = kept[i];
  fresh_ = true;
}

// The forces that hold the state belong to the matrices of before, so that the next step has to be
// whole.
void QuasiStatic::renewed(const Mesh& mesh) {
  complete();
  CondensedIntegrator::renewed(mesh);
  renewed_ = true;
}

// Solves for loads, and for displacements of held dofs if they are new.
void QuasiStatic::load_tissue() {
  PetscReal size = 0;
  check(VecNorm(load_, NORM_INFINITY, &size));  // remembered by PETSc while nothing changes
  if (size == 0 && !fresh_) return;
  fresh_ = false;
  {
    Entries held(held_u_.get());
    Entries u(u_.get());
    for (const auto& c : held_) {
      if (u.owns(c.dof)) u[c.dof] = held[c.dof] = c.value;
    }
  }
  loaded_ = size > 0 || std::ranges::any_of(held_, [](const auto& c) { return c.value != 0; });
  if (!loaded_) {
    check(VecSet(rhs_.get(), 0));
    near_.unload();
    return;
  }
  cells_.stiffness(held_u_.get(), rhs_.get());
  check(VecAYPX(rhs_.get(), -1, load_));
  check(VecCopy(rhs_.get(), balanced_.get()));
  {
    Entries b(balanced_.get());
    for (const auto& c : held_) {
      if (b.owns(c.dof)) b[c.dof] = 0;
    }
  }
  near_.load(balanced_.get());
}

void QuasiStatic::make_near(std::span<const int> dofs) {
  if (std::ranges::all_of(dofs,
                          [&](int dof) { return near_.is_near(dof) || near_.eliminated(dof); })) {
    return;
  }
  complete_displacement();
  near_.include(dofs);
  const Vec vectors[1] = {state_->u.get()};
  auto values = near_.values(vectors, start_.size())[0];
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t at = start_.size() + i;
    if (near_.is_row(at)) values[i] += rows_.rest_of(near_.coordinates()[at]);
  }
  start_.insert(start_.end(), values.begin(), values.end());
  accepted_.insert(accepted_.end(), values.begin(), values.end());
  pushed_.resize(start_.size(), 0.0);
}

void QuasiStatic::watch(std::span<const int> coordinates) {
  // Before the first step the state is whole.
  if (state_ != nullptr && !near_.wants_factor()) make_near(coordinates);
}

void QuasiStatic::leave_track() {
  complete();
  CondensedIntegrator::leave_track();
  start_.clear();
  accepted_.clear();
  pushed_.clear();
  last_pushed_.clear();
  forced_.clear();
  loaded_forces_.clear();
  fresh_ = true;
}

RowTrial QuasiStatic::row(int coordinate) const {
  const std::size_t at = near_.at(coordinate);
  const double u = solution_.x[at];
  return {start_[at], u, (u - start_[at]) / h_, solution_.reaction[at]};
}

// What edits moved is near; what their elements touch becomes so.
void QuasiStatic::take_edits() {
  const std::vector<int> dofs = stylet::dofs_of(edited_);
  make_near(dofs);
  edited_.clear();
  near_.changed(tissue_.stiffness(), dofs);
  const Vec vectors[1] = {state_->u.get()};
  const auto values = gather(vectors, dofs)[0];
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    if (near_.is_near(dofs[i])) start_[near_.at(dofs[i])] = values[i];
  }
  if (loaded_) fresh_ = true;
}

Trial QuasiStatic::attempt(const ConstraintSet& constraints, bool) {
  if (!edited_.empty()) {
    take_edits();
    load_tissue();
  }
  make_near(dofs_of(constraints));
  push(constraints, {});
  demand_.given.clear();
  for (const auto& c : constraints.dofs) {
    const std::size_t at = near_.at(c.dof);
    demand_.given.push_back({at, c.velocity ? start_[at] + h_ * c.value : c.value});
  }
  std::vector<double> start(start_.size());
  for (std::size_t i = 0; i < start.size(); ++i) start[i] = -start_[i] / h_;
  damp(constraints, 1 / h_, start);
  demand_.weights.clear();
  demand_.value = 0;
  demand_.rest = 0;
  if (constraints.mean) {
    double& value = demand_.value;
    value = constraints.mean->value;
    demand_.rest = constraints.mean->rest;
    for (const auto& [dof, weight] : constraints.mean->weights) {
      if (!near_.eliminated(dof)) {
        demand_.weights.push_back({near_.at(dof), weight});
        continue;
      }
      const auto held = std::ranges::find(held_, dof, &PrescribedDof::dof);
      value -= weight * held->value;
    }
    if (demand_.weights.empty()) throw_all_held();
  }
  solution_ = near_.solve(extra_, demand_);
  trial_ = near_trial([&](std::size_t i) { return solution_.x[i]; },
                      [&](std::size_t i) { return (solution_.x[i] - start_[i]) / h_; });
  trial_.iterations = near_.take_iterations();
  return trial_;
}

Trial QuasiStatic::finish(bool whole) {
  whole_step_ = whole || loaded_ || renewed_;
  if (!whole_step_) return trial_;
  complete();
  const auto balance = [&](Vec x, Vec residual) {
    cells_.stiffness(x, residual);
    check(VecAXPY(residual, -1, rhs_.get()));
    take_extra(residual, extra_);
  };
  PetscReal largest = 0;
  check(VecNorm(rhs_.get(), NORM_INFINITY, &largest));
  near_.complete(balance, largest, extra_, demand_, solution_, u_.get(), work_.get());
  fresh_ = true;  // the near field may have solved for a correction
  collect_reactions(work_.get());
  if (loaded_) check(VecAXPY(u_.get(), 1, held_u_.get()));
  check(VecWAXPY(v_.get(), -1, state_->u.get(), u_.get()));
  check(VecScale(v_.get(), 1 / h_));
  trial_ = at_end(u_.get(), v_.get(), {reaction_.get(), solution_.lambda});
  return trial_;
}

StoredEnergy QuasiStatic::energy(const State& state) {
  if (stored_of_ == StateVersion(state)) return stored_;
  complete();
  cells_.stiffness(state.u.get(), work_.get());
  PetscScalar twice = 0;
  check(VecDot(state.u.get(), work_.get(), &twice));
  return {0, 0.5 * twice + rows_.energy()};
}

void QuasiStatic::accept() {
  whole_u_ = whole_v_ = whole_step_;
  accepted_h_ = h_;
  renewed_ = false;
  if (whole_step_) {
    check(VecCopy(u_.get(), state_->u.get()));
    check(VecCopy(v_.get(), state_->v.get()));
  } else {
    Entries u(state_->u.get());
    Entries v(state_->v.get());
    for (std::size_t i = 0; i < near_.coordinates().size(); ++i) {
      const int dof = near_.coordinates()[i];
      if (!u.owns(dof)) continue;
      u[dof] = solution_.x[i];
      v[dof] = (solution_.x[i] - start_[i]) / h_;
    }
  }
  std::swap(last_pushed_, pushed_);
  pushed_ = near_.factored_forces(solution_.x);
  rows_.keep(near_, extra_, demand_, solution_);
  if (whole_step_) {
    stored_of_ = {};
  } else {
    const auto& x = solution_.x;
    stored_ = {0, 0.5 * (dot(x, pushed_) + dot(x, near_.changed_forces(x)))};
    stored_of_ = StateVersion(*state_);
  }
  accepted_ = solution_.x;
  start_ = solution_.x;
  forced_.clear();
  for (const auto& g : demand_.given) forced_.push_back(near_.coordinates()[g.at]);
  for (const auto& s : demand_.springs) forced_.push_back(near_.coordinates()[s.at]);
  for (const auto& w : demand_.weights) forced_.push_back(near_.coordinates()[w.at]);
  for (std::size_t i = 0; i < extra_.size(); ++i) {
    if (extra_[i] != 0) forced_.push_back(near_.coordinates()[i]);
  }
  sort_unique(forced_);
  state_->t += h_;
}

// The near dofs hold their values already, maybe edited since.
void QuasiStatic::complete_displacement() {
  if (whole_u_) return;
  whole_u_ = true;
  near_.respond(pushed_, u_.get());
  keep_near(state_->u.get(), u_.get());
}

void QuasiStatic::complete() {
  complete_displacement();
  if (whole_v_) return;
  whole_v_ = true;
  near_.respond(last_pushed_, work_.get());
  check(VecAXPBY(work_.get(), 1 / accepted_h_, -1 / accepted_h_, state_->u.get()));
  keep_near(state_->v.get(), work_.get());
}

// Copies `from` to a vector of the state, but for the near dofs.
void QuasiStatic::keep_near(Vec state, Vec from) const {
  {
    Entries values(from);
    const Values near(state);
    for (const int dof : near_.coordinates()) {
      if (values.owns(dof)) values[dof] = near[dof];
    }
  }
  check(VecCopy(from, state));
}

}  // namespace stylet
