#include "stylet/dynamics/explicit_track.hpp"

namespace stylet {

void ExplicitTrack::follow(const TrackOperator& track) {
  near_.follow(&track);
  rows_.follow(track);
}

void ExplicitTrack::leave() {
  near_.follow(nullptr);
  rows_.leave();
  start_.clear();
  n_placed_ = 0;
}

void ExplicitTrack::watch(std::span<const int> coordinates, Vec u) {
  near_.include(coordinates);
  const Vec vectors[1] = {u};
  const auto values = near_.values(vectors, start_.size())[0];
  for (const double tissue : values) {
    start_.push_back(tissue + rows_.rest_of(near_.coordinates()[start_.size()]));
  }
}

void ExplicitTrack::place(Vec u, bool moved) {
  if (!moved && n_placed_ == start_.size()) return;
  n_placed_ = start_.size();
  const Vec vectors[1] = {u};
  near_.stand_still(near_.values(vectors)[0]);
}

double ExplicitTrack::solve(const ConstraintSet& constraints, double h) {
  h_ = h;
  extra_.assign(start_.size(), 0.0);
  for (const auto& [row, force] : constraints.forces) extra_[near_.at(row)] += force;
  demand_ = {};
  for (const auto& c : constraints.dofs) {
    const std::size_t at = near_.at(c.dof);
    demand_.given.push_back({at, c.velocity ? start_[at] + h * c.value : c.value});
  }
  for (const auto& [row, coefficient, speed] : constraints.dashpots) {
    const std::size_t at = near_.at(row);
    demand_.springs.push_back({at, coefficient * (speed + start_[at] / h), coefficient / h});
  }
  if (constraints.mean) {
    demand_.value = constraints.mean->value;
    demand_.rest = constraints.mean->rest;
    for (const auto& [row, weight] : constraints.mean->weights) {
      demand_.weights.push_back({near_.at(row), weight});
    }
  }
  solution_ = near_.solve(extra_, demand_);
  return solution_.lambda;
}

RowTrial ExplicitTrack::row(int coordinate) const {
  const std::size_t at = near_.at(coordinate);
  const double u = solution_.x[at];
  return {start_[at], u, (u - start_[at]) / h_, solution_.reaction[at]};
}

void ExplicitTrack::each_force(const std::function<void(int, double)>& force) const {
  std::vector<double> on = extra_;
  for (std::size_t i = 0; i < on.size(); ++i) on[i] += solution_.reaction[i];
  for (const auto& [at, weight] : demand_.weights) on[at] += solution_.lambda * weight;
  for (std::size_t i = 0; i < on.size(); ++i) {
    if (on[i] == 0) continue;
    for (const auto& [dof, weight] : rows_.track().row(place_of(n_dofs_, near_.coordinates()[i]))) {
      force(dof, weight * on[i]);
    }
  }
}

void ExplicitTrack::accept() {
  rows_.keep(near_, extra_, demand_, solution_);
  start_ = solution_.x;
}

}  // namespace stylet
