// What the needle's laws ask of the tissue and hear of it: points of the track and directions. Which nodes
// stand behind a point its row of B knows (solvers/track_operator.hpp).
#pragma once

#include "stylet/needle/value_table.hpp"
#include "stylet/solvers/track_operator.hpp"

#include <optional>
#include <vector>

namespace stylet {

/// Of a point: along the needle in the direction of insertion, and across it.
struct TrackVector {
  double along = 0;
  double across = 0;
  double across_too = 0;  ///< in space
};

/// End of the step as tried.
struct PointTrial {
  TrackVector u;         ///< m
  TrackVector v;         ///< m/s
  TrackVector reaction;  ///< N, needed by what is held
  TrackVector working;   ///< N, as in Trial
  TrackVector settled;   ///< N, as in Trial
};
using TrackTrial = ValueTable<PointTrial>;

/// Displacements at the start of the step (m).
using TrackStart = ValueTable<TrackVector>;

/// A displacement (m) or velocity (m/s) that is given at the end of the step.
struct TrackHold {
  TrackPlace place;
  double value;
  bool velocity = false;
};

struct TrackForce {
  TrackPlace place;
  double force;  ///< N, on the tissue
};

/// Share of the tip's load.
struct PointShare {
  int point;
  double value;
};

/// The one condition of a tip: the mean displacement along under its shares, as in MeanCondition.
struct TrackMean {
  std::vector<PointShare> shares;
  double value = 0;
  double rate = 0;
  bool by_rate = false;
  double rest = 0;  ///< what it moves beyond its points by a unit of load (m/N)
};

/// The force coefficient (speed - v), v the velocity of the place at the end of the step, as Dashpot.
struct TrackDashpot {
  TrackPlace place;
  double coefficient;  ///< N s/m
  double speed;        ///< m/s
};

struct TrackConditions {
  std::vector<TrackHold> held;  ///< each place at most once
  std::optional<TrackMean> mean;
  std::vector<TrackForce> forces;
  std::vector<TrackDashpot> dashpots;
};

}  // namespace stylet
