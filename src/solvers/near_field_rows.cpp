// Rows of B in the near field: from dofs to near coordinates and back.
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/solvers/near_field.hpp"

#include <utility>

namespace stylet {

void NearField::follow(const TrackOperator* track) {
  if (!only_dofs_) {
    stale_ = stale_ || !changed_.empty();
    leave_all();
  }
  track_ = track;
}

// Nothing is near.
void NearField::leave_all() {
  whole_.leave_rows();
  coordinates_.clear();
  rows_.clear();
  free_rows_.clear();
  only_dofs_ = true;
  index_.clear();
  changed_.clear();
  is_changed_.clear();
  s_.clear();
  k_.clear();
  l_.clear();
  mask_.clear();
  valid_ = 0;
  y_near_.clear();
  s_y_.clear();
}

void NearField::stand_still(std::vector<double> values) {
  y_near_ = std::move(values);
  s_y_ = factored_forces(y_near_);
}

// Those that rows from the `from`-th on need, row by row.
std::vector<int> NearField::dofs_behind(std::size_t from) const {
  std::vector<int> dofs;
  for (std::size_t i = from; i < size(); ++i) {
    if (!is_row(i)) dofs.push_back(coordinates_[i]);
    for (const auto& [dof, weight] : rows_[i]) dofs.push_back(dof);
  }
  return dofs;
}

// Of values at `dofs_behind`.
std::vector<double> NearField::sum_rows(std::size_t from, std::span<const double> values) const {
  std::vector<double> sums;
  auto next = values.begin();
  for (std::size_t i = from; i < size(); ++i) {
    double sum = is_row(i) ? 0 : *next++;
    for (const auto& [dof, weight] : rows_[i]) sum += weight * *next++;
    sums.push_back(sum);
  }
  return sums;
}

std::vector<std::vector<double>> NearField::values(std::span<const Vec> vectors,
                                                   std::size_t from) const {
  auto values = gather(vectors, dofs_behind(from));
  for (auto& of_vector : values) of_vector = sum_rows(from, of_vector);
  return values;
}

void NearField::subtract(std::size_t at, double force, Entries& r) const {
  if (force == 0) return;
  const int c = coordinates_[at];
  if (!is_row(at) && r.owns(c)) r[c] -= force;
  for (const auto& [dof, weight] : rows_[at]) {
    if (r.owns(dof)) r[dof] -= weight * force;
  }
}

std::vector<double> NearField::loaded(std::size_t from) {
  if (still_) return std::vector<double>(size() - from, 0.0);
  return only_dofs_ ? whole_.loaded(std::span(coordinates_).subspan(from))
                    : whole_.loaded(free_rows_, from);
}

// x = A0^-1 B^T forces. What falls on eliminated dofs their supports bear.
void NearField::answer(std::span<const double> forces, bool add_loaded, Vec x) {
  if (only_dofs_) {
    whole_.respond(std::span(coordinates_).first(forces.size()), forces, add_loaded, x);
    return;
  }
  whole_.respond(free_rows_, forces, add_loaded, x);
}

// Columns of W from the `from`-th on: [column * size() + row].
std::vector<double> NearField::compliance(std::size_t from) {
  if (only_dofs_) {
    return whole_.inverse_entries(coordinates_, std::span(coordinates_).subspan(from));
  }
  for (std::size_t i = free_rows_.size(); i < size(); ++i) {
    free_rows_.push_back(is_row(i) ? rows_[i] : SparseRow{{coordinates_[i], 1}});
    std::erase_if(free_rows_.back(),
                  [&](const DofValue& entry) { return held_.contains(entry.dof); });
  }
  std::vector<double> w = still_ ? std::vector<double>(size() * (size() - from), 0.0)
                                 : whole_.inverse_entries(free_rows_, from);
  for (std::size_t j = from; j < size(); ++j) {
    for (std::size_t i = 0; i < size() && is_row(j); ++i) {
      if (!is_row(i)) continue;
      w[(j - from) * size() + i] +=
          track_->rest(place_of(n_dofs_, coordinates_[i]), place_of(n_dofs_, coordinates_[j]));
    }
  }
  return w;
}

}  // namespace stylet
