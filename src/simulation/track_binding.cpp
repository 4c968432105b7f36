#include "stylet/simulation/track_binding.hpp"

#include "stylet/base/sorted.hpp"

namespace stylet {

Coordinate find_coordinate(const TrackOperator& track, TrackPlace place, int n_dofs) {
  if (const auto one = track.dof(place)) return {one->dof, one->value};
  return {coordinate_of(n_dofs, place), 1};
}

ConstraintSet bind(const TrackConditions& conditions, const TrackOperator& track, int n_dofs) {
  ConstraintSet set;
  for (const auto& [place, value, velocity] : conditions.held) {
    const auto [index, sign] = find_coordinate(track, place, n_dofs);
    set.dofs.push_back({index, sign * value, velocity});
  }
  for (const auto& [place, force] : conditions.forces) {
    const auto [index, sign] = find_coordinate(track, place, n_dofs);
    set.forces.push_back({index, sign * force});
  }
  for (const auto& [place, coefficient, speed] : conditions.dashpots) {
    const auto [index, sign] = find_coordinate(track, place, n_dofs);
    set.dashpots.push_back({index, coefficient, sign * speed});
  }
  if (!conditions.mean) return set;
  auto& mean = set.mean.emplace();
  mean.value = conditions.mean->value;
  mean.rate = conditions.mean->rate;
  mean.by_rate = conditions.mean->by_rate;
  mean.rest = conditions.mean->rest;
  for (const auto& [point, share] : conditions.mean->shares) {
    const auto [index, sign] = find_coordinate(track, {point, Component::along}, n_dofs);
    mean.weights.push_back({index, sign * share});
  }
  return set;
}

std::vector<int> coordinates_of(const TrackOperator& track,
                                std::span<const int> points,
                                int n_dofs) {
  std::vector<int> coordinates;
  for (const int point : points) {
    for (int k = 0; k < track.n_components(); ++k) {
      const TrackPlace place{point, static_cast<Component>(k)};
      coordinates.push_back(find_coordinate(track, place, n_dofs).index);
    }
  }
  sort_unique(coordinates);
  return coordinates;
}

}  // namespace stylet
