#include "stylet/dynamics/condensed_integrator.hpp"

#include "stylet/base/sorted.hpp"
#include "stylet/petsc/check.hpp"

#include <numeric>

namespace stylet {

CondensedIntegrator::CondensedIntegrator(TissueOperator& tissue, const Mesh& mesh)
    : tissue_(tissue),
      cells_(mesh, tissue),
      near_(tissue.comm(), tissue.n_dofs()),
      rows_(tissue.n_dofs()) {
  for (OwnedVec* vec : {&u_, &v_, &reaction_, &rhs_, &work_}) {
    *vec = tissue.make_vector();
    check(VecSet(vec->get(), 0));
  }
}

void CondensedIntegrator::touched(const Mesh& mesh, std::span<const int> cells) {
  cells_.update(mesh, cells);
  const auto rows = tissue_.rows_of(mesh, cells);
  edited_.insert(edited_.end(), rows.begin(), rows.end());
  sort_unique(edited_);
}

void CondensedIntegrator::renewed(const Mesh& mesh) {
  std::vector<int> all(static_cast<std::size_t>(mesh.n_cells()));
  std::iota(all.begin(), all.end(), 0);
  cells_.update(mesh, all);
  near_.forget();
  stored_of_ = {};
}

StoredEnergy CondensedIntegrator::energy(const State& state) {
  if (stored_of_ == StateVersion(state)) return stored_;
  PetscScalar twice[2] = {0, 0};
  cells_.stiffness_and_mass(state.u.get(), state.v.get(), work_.get(), rhs_.get());
  check(VecDot(state.u.get(), work_.get(), &twice[0]));
  check(VecDot(state.v.get(), rhs_.get(), &twice[1]));
  return {0.5 * twice[1], 0.5 * twice[0] + rows_.energy()};
}

std::vector<int> CondensedIntegrator::dofs_of(const ConstraintSet& constraints) {
  std::vector<int> dofs;
  for (const auto& c : constraints.dofs) dofs.push_back(c.dof);
  for (const auto& [dof, force] : constraints.forces) dofs.push_back(dof);
  for (const auto& dashpot : constraints.dashpots) dofs.push_back(dashpot.dof);
  if (constraints.mean) {
    for (const auto& [dof, weight] : constraints.mean->weights) dofs.push_back(dof);
  }
  return dofs;
}

void CondensedIntegrator::push(const ConstraintSet& constraints, std::span<const double> change) {
  extra_.assign(change.begin(), change.end());
  extra_.resize(near_.coordinates().size(), 0.0);
  for (const auto& [dof, force] : constraints.forces) {
    if (!near_.eliminated(dof)) extra_[near_.at(dof)] += force;
  }
}

void CondensedIntegrator::damp(const ConstraintSet& constraints,
                               double rate,
                               const std::vector<double>& start) {
  demand_.springs.clear();
  for (const auto& [dof, coefficient, speed] : constraints.dashpots) {
    const std::size_t at = near_.at(dof);
    const double of_it = near_.is_row(at) ? 1 / h_ : rate;
    demand_.springs.push_back({at, coefficient * (speed - start[at]), coefficient * of_it});
  }
}

void CondensedIntegrator::follow(const TrackOperator& track) {
  rows_.follow(track);
  near_.follow(&track);
}

void CondensedIntegrator::leave_track() {
  rows_.leave();
  near_.follow(nullptr);
  stored_of_ = {};
}

void CondensedIntegrator::take_extra(Vec residual, std::span<const double> extra) const {
  Entries r(residual);
  for (std::size_t i = 0; i < extra.size(); ++i) near_.subtract(i, extra[i], r);
}

void CondensedIntegrator::collect_reactions(Vec residual) {
  check(VecSet(reaction_.get(), 0));
  Entries reaction(reaction_.get());
  const Values left(residual);
  for (const auto& c : held_) {
    if (left.owns(c.dof)) reaction[c.dof] = left[c.dof];
  }
  for (const auto& g : demand_.given) {
    const int dof = near_.coordinates()[g.at];
    if (left.owns(dof)) reaction[dof] = solution_.reaction[g.at];
  }
}

}  // namespace stylet
