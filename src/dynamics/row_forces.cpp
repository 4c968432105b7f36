#include "stylet/dynamics/row_forces.hpp"

namespace stylet {

void RowForces::leave() {
  track_ = nullptr;
  forces_.clear();
}

double RowForces::rest_of(int coordinate) const {
  double sum = 0;
  const TrackPlace place = place_of(n_dofs_, coordinate);
  for (const auto& [other, force] : forces_) {
    sum += force * track_->rest(place, place_of(n_dofs_, other));
  }
  return sum;
}

double RowForces::energy() const {
  double twice = 0;
  for (const auto& [coordinate, force] : forces_) twice += force * rest_of(coordinate);
  return 0.5 * twice;
}

void RowForces::keep(const NearField& near,
                     std::span<const double> extra,
                     const NearField::Demand& demand,
                     const NearField::Solution& solution) {
  forces_.clear();
  if (track_ == nullptr) return;
  std::vector<double> on(extra.begin(), extra.end());
  for (std::size_t i = 0; i < on.size(); ++i) on[i] += solution.reaction[i];
  for (const auto& [at, weight] : demand.weights) on[at] += solution.lambda * weight;
  for (std::size_t i = 0; i < on.size(); ++i) {
    if (near.is_row(i) && on[i] != 0) forces_.push_back({near.coordinates()[i], on[i]});
  }
}

void RowForces::archive(Archive& archive) {
  std::size_t size = forces_.size();
  archive("size", size);
  forces_.resize(size);
  for (auto& [coordinate, force] : forces_) {
    int row = coordinate - n_dofs_;
    archive("row", row);
    coordinate = row + n_dofs_;
    archive("force", force);
  }
}

}  // namespace stylet
