// The tissue as a needle's track sees it.
#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/simulation/body.hpp"
#include "stylet/simulation/track_binding.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

namespace {

constexpr const char* no_number =
    "the solver gives what is not a number; go on with --resume, and if that ends alike, the scene "
    "has numbers that are too large or too small";

bool is_number(TrackVector x) {
  return std::isfinite(x.along + x.across + x.across_too);
}

}  // namespace

// Values of vectors at points of a track.
std::vector<std::vector<TrackVector>> Body::on_track(const TrackOperator& track,
                                                     std::span<const int> points,
                                                     std::span<const Vec> vectors) const {
  std::vector<int> dofs;
  std::vector<double> signs;
  for (const int point : points) {
    for (const Component component : {Component::along, Component::across}) {
      const auto [dof, sign] = find_coordinate(track, {point, component}, tissue_->n_dofs());
      dofs.push_back(dof);
      signs.push_back(sign);
    }
  }
  std::vector<std::vector<TrackVector>> result;
  for (const auto& values : gather(vectors, dofs)) {
    auto& of_vector = result.emplace_back();
    for (std::size_t i = 0; i < dofs.size(); i += 2) {
      of_vector.push_back({signs[i] * values[i], signs[i + 1] * values[i + 1]});
    }
  }
  return result;
}

TrackStart Body::view(const TrackOperator& track, std::span<const int> points) const {
  const std::vector<int> keys(points.begin(), points.end());
  if (scene_.dim() == 3) {
    return {keys, rows_of(points, [](const RowTrial& row) { return row.start; })};
  }
  std::vector<int> nodes;
  for (const int dof : coordinates_of(track, points, tissue_->n_dofs())) nodes.push_back(dof / 2);
  sort_unique(nodes);
  integrator_->complete_at(nodes);
  const Vec vectors[1] = {state_.u.get()};
  return {keys, on_track(track, points, vectors)[0]};
}

template <class Value>
std::vector<TrackVector> Body::rows_of(std::span<const int> points, Value&& value) const {
  std::vector<TrackVector> values;
  for (const int point : points) {
    const auto of = [&](Component component) {
      return value(integrator_->row(coordinate_of(tissue_->n_dofs(), {point, component})));
    };
    values.push_back({of(Component::along), of(Component::across), of(Component::across_too)});
  }
  return values;
}

TrackTrial Body::view(const TrackOperator& track,
                      std::span<const int> points,
                      const Trial& trial) const {
  std::vector<std::vector<TrackVector>> values;
  if (scene_.dim() == 3) {
    values.push_back(rows_of(points, [](const RowTrial& row) { return row.u; }));
    values.push_back(rows_of(points, [](const RowTrial& row) { return row.v; }));
    values.resize(5, rows_of(points, [](const RowTrial& row) { return row.reaction; }));
  } else {
    const Vec vectors[5] = {trial.u, trial.v, trial.needed.reaction, trial.working.reaction,
                            trial.settled.reaction};
    values = on_track(track, points, vectors);
  }
  for (const auto& each : values) {
    if (!std::ranges::all_of(each, is_number)) throw NumericalError(no_number);
  }
  std::vector<PointTrial> trials;
  for (std::size_t i = 0; i < points.size(); ++i) {
    trials.push_back({values[0][i], values[1][i], values[2][i], values[3][i], values[4][i]});
  }
  return {std::vector<int>(points.begin(), points.end()), std::move(trials)};
}

// Points ahead come along: solving for some columns at once costs little more than for one.
void Body::watch(const TrackOperator& track, std::span<const int> points) {
  constexpr int together = 8;
  std::vector<int> watched(points.begin(), points.end());
  while (!watched.empty() && watched.back() + 1 < track.n_points() &&
         (watched.back() + 1) % together != 0) {
    watched.push_back(watched.back() + 1);
  }
  integrator_->watch(coordinates_of(track, watched, tissue_->n_dofs()));
}

void Body::follow(const TrackOperator& track) {
  if (scene_.dim() == 3) integrator_->follow(track);
}

void Body::leave_track() {
  integrator_->leave_track();
}

}  // namespace stylet
