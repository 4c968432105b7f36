// Between a needle, which speaks of points of its track, and the solver, which hears of dofs and rows.
#pragma once

#include "stylet/needle/track_view.hpp"
#include "stylet/solvers/constraint_set.hpp"

#include <span>
#include <vector>

namespace stylet {

/// A place as the solver knows it: `sign` times the displacement of a dof, or a row behind the mesh's dofs.
struct Coordinate {
  int index;
  double sign;
};
[[nodiscard]] Coordinate find_coordinate(const TrackOperator& track, TrackPlace place, int n_dofs);

/// n_dofs: of the mesh.
[[nodiscard]] ConstraintSet bind(const TrackConditions& conditions,
                                 const TrackOperator& track,
                                 int n_dofs);

/// All components of these points; ascending.
[[nodiscard]] std::vector<int> coordinates_of(const TrackOperator& track,
                                              std::span<const int> points,
                                              int n_dofs);

}  // namespace stylet
