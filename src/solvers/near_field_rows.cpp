// Rows of B in the near field: from dofs to near coordinates and back.
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/session.hpp"
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

// Sums of what each rank owns: the values of a dof are then its owner's.
std::vector<std::vector<double>> NearField::values(std::span<const Vec> vectors,
                                                   std::size_t from) const {
  const std::size_t n = size() - from;
  std::vector<double> sums;
  sums.reserve(vectors.size() * n);
  for (Vec vector : vectors) {
    const Values x(vector);
    for (std::size_t i = from; i < size(); ++i) {
      const int c = coordinates_[i];
      double sum = !is_row(i) && x.owns(c) ? x[c] : 0;
      for (const auto& [dof, weight] : rows_[i]) {
        if (x.owns(dof)) sum += weight * x[dof];
      }
      sums.push_back(sum);
    }
  }
  if (size_of(comm_) > 1 && n > 0) {
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                  comm_);
  }
  std::vector<std::vector<double>> values;
  for (std::size_t k = 0; k < vectors.size(); ++k) {
    const auto first = sums.begin() + static_cast<std::ptrdiff_t>(k * n);
    values.emplace_back(first, first + static_cast<std::ptrdiff_t>(n));
  }
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
