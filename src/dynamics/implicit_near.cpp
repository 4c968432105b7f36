// Steps of ImplicitNewmark in the near field.
#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>

namespace stylet {

namespace {

// Row of an owned dof times a vector known at `columns`, ascending, which hold all of the row.
double row_product(Mat matrix,
                   int row,
                   const std::vector<int>& columns,
                   const std::vector<double>& values) {
  PetscInt n = 0;
  const PetscInt* at = nullptr;
  const PetscScalar* entries = nullptr;
  check(MatGetRow(matrix, row, &n, &at, &entries));
  double sum = 0;
  for (PetscInt j = 0; j < n; ++j) {
    // Couplings kept for edge flips are zero and may lie outside.
    if (entries[j] == 0) continue;
    const auto found = std::ranges::lower_bound(columns, at[j]) - columns.begin();
    sum += entries[j] * values[static_cast<std::size_t>(found)];
  }
  check(MatRestoreRow(matrix, row, &n, &at, &entries));
  return sum;
}

}  // namespace

// Predictors of dofs that became near.
void ImplicitNewmark::refresh_near() {
  const std::span<const int> dofs = near_->dofs();
  const Vec vectors[2] = {u_guess_.get(), v_guess_.get()};
  if (dofs.size() == u_near_.size()) return;
  const auto values = gather(vectors, dofs.subspan(u_near_.size()));
  u_near_.insert(u_near_.end(), values[0].begin(), values[0].end());
  v_near_.insert(v_near_.end(), values[1].begin(), values[1].end());
  change_.resize(dofs.size(), 0.0);
}

void ImplicitNewmark::watch(std::span<const int> nodes) {
  if (!near_) return;
  watched_ = dofs_of(nodes);
  if (!fresh_) near_->include(watched_);  // else once the operator is made
}

// Predictors, right-hand side and operator at the nodes whose rows changed; the same as `predict`
// would give.
void ImplicitNewmark::predict_edited() {
  static const LogEvent event("StyletPredict");
  const LogScope scope(event);
  const std::vector<int> dofs = dofs_of(edited_);
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
      set_owned(u_guess_.get(), dof, inertia_ ? u + h_ * v + c0 * a : u);
      set_owned(v_guess_.get(), dof, inertia_ ? v + h_ * k_.g0 * a : 0);
    }
  }
  near_->changed(tissue_.tangent_matrix(), dofs);
  refresh_near();
  const std::vector<int> columns = dofs_of(surrounding_);
  const Vec vectors[4] = {u_guess_.get(), v_guess_.get(), state_->a.get(), held_increment_.get()};
  const auto values = gather(vectors, columns);
  const auto damping = inertia_ ? tissue_.damping().value_or(RayleighDamping{}) : RayleighDamping{};
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
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      if (!load.owns(dofs[i])) continue;
      double rhs = load[dofs[i]] - row_product(tissue_.stiffness(), dofs[i], columns, stretched);
      if (k_.alpha_m != 0 || damping.mass_factor != 0) {
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
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, change.data(), static_cast<int>(change.size()),
                            MPI_DOUBLE, MPI_SUM, tissue_.comm()));
  }
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    if (near_->eliminated(dofs[i])) continue;
    const std::size_t at = near_->at(dofs[i]);
    const auto from =
        static_cast<std::size_t>(std::ranges::lower_bound(columns, dofs[i]) - columns.begin());
    u_near_[at] = values[0][from];
    v_near_[at] = values[1][from];
    change_[at] = change[i];
  }
  edited_.clear();
}

Trial ImplicitNewmark::attempt_near(const ConstraintSet& constraints) {
  std::vector<int> dofs;
  for (const auto& c : constraints.dofs) dofs.push_back(c.dof);
  for (const auto& [dof, force] : constraints.forces) dofs.push_back(dof);
  if (constraints.mean) {
    for (const auto& [dof, weight] : constraints.mean->weights) dofs.push_back(dof);
  }
  near_->include(dofs);
  refresh_near();
  extra_ = change_;
  for (const auto& [dof, force] : constraints.forces) {
    if (!near_->eliminated(dof)) extra_[near_->at(dof)] += force;
  }
  given_.clear();
  for (const auto& c : constraints.dofs) {
    const std::size_t at = near_->at(c.dof);
    given_.push_back({at, increment_of(c, u_near_[at], v_near_[at])});
  }
  weights_.clear();
  double value = 0;
  if (constraints.mean) {
    double u = 0;
    double moved = 0;  // by held dofs
    for (const auto& [dof, weight] : constraints.mean->weights) {
      if (near_->eliminated(dof)) {
        const Vec vectors[2] = {u_guess_.get(), held_increment_.get()};
        const int one[1] = {dof};
        const auto held = gather(vectors, one);
        u += weight * held[0][0];
        moved += weight * held[1][0];
        continue;
      }
      weights_.push_back({near_->at(dof), weight});
      u += weight * u_near_[weights_.back().at];
    }
    value = constraints.mean->value - u - moved;
    if (weights_.empty()) throw_all_held();
  }
  solution_ = near_->solve(extra_, given_, weights_, value);
  Entries u(u_.get());
  Entries v(v_.get());
  Entries reaction(reaction_.get());
  for (std::size_t i = 0; i < near_->dofs().size(); ++i) {
    const int dof = near_->dofs()[i];
    if (!u.owns(dof)) continue;
    u[dof] = u_near_[i] + solution_.x[i];
    v[dof] = v_near_[i] + speed() * solution_.x[i];
    reaction[dof] = solution_.reaction[i];
  }
  return at_end(u_.get(), v_.get(), {reaction_.get(), solution_.lambda});
}

// The last trial at all dofs.
void ImplicitNewmark::complete_near() {
  check(VecCopy(rhs_base_.get(), rhs_.get()));
  {
    Entries rhs(rhs_.get());
    for (std::size_t i = 0; i < near_->dofs().size(); ++i) {
      const int dof = near_->dofs()[i];
      if (rhs.owns(dof)) rhs[dof] += extra_[i];
    }
  }
  near_->complete(tissue_.tangent_matrix(), rhs_.get(), given_, weights_, solution_,
                  increment_.get(), work_.get());
  check(VecSet(reaction_.get(), 0));
  {
    Entries reaction(reaction_.get());
    const Values r(work_.get());
    for (const auto& c : held_) {
      if (r.owns(c.dof)) reaction[c.dof] = r[c.dof];
    }
    for (const auto& g : given_) {
      const int dof = near_->dofs()[g.at];
      if (r.owns(dof)) reaction[dof] = solution_.reaction[g.at];
    }
  }
  if (held_move_) check(VecAXPY(increment_.get(), 1, held_increment_.get()));
  check(VecWAXPY(u_.get(), 1, increment_.get(), u_guess_.get()));
  check(VecWAXPY(v_.get(), speed(), increment_.get(), v_guess_.get()));
}

Trial ImplicitNewmark::finish(bool) {
  if (near_) complete_near();
  if (near_) {
    trial_ = at_end(u_.get(), v_.get(), {reaction_.get(), solution_.lambda});
    trial_.only_end = inertia_ && damps_at_once();
    if (has_blow_) settle();
  }
  return trial_;
}

}  // namespace stylet
