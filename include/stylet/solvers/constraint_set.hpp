// What holds and pushes the tissue during one step. Dofs beyond the mesh's own are rows of the track
// that the integrator follows (coordinate_of).
#pragma once

#include "stylet/solvers/track_operator.hpp"

#include <optional>
#include <vector>

namespace stylet {

/// A dof whose displacement (m) or velocity (m/s) at the end of the step is given.
struct PrescribedDof {
  int dof;
  double value;
  bool velocity = false;
};

/// The one condition of a tip: sum of weight times displacement = value at the end of the step (m),
/// moving at `rate` (m/s). The weights sum to +-1; its multiplier lambda (N) loads the dofs with
/// lambda times the weights.
struct MeanCondition {
  std::vector<DofValue> weights;
  double value = 0;
  double rate = 0;
  /// Only the rate is asked for: a gap that was there when the contact began stays. For integrators that
  /// decide by velocity.
  bool by_rate = false;
  double rest = 0;  ///< what the mean moves beyond the dofs by a unit of lambda (m/N); of rows
};

/// Pulls a dof along with coefficient (speed - v), v its velocity at the end of the step: a force that is
/// solved for with the step, since one of the velocity before would be neither stable nor the same on
/// shorter steps.
struct Dashpot {
  int dof;
  double coefficient;  ///< N s/m
  double speed;        ///< m/s
};

struct ConstraintSet {
  std::vector<PrescribedDof> dofs;  ///< each dof at most once
  std::optional<MeanCondition> mean;
  std::vector<DofValue> forces;   ///< N, on dofs
  std::vector<Dashpot> dashpots;  ///< on dofs that are not prescribed, each at most once
  bool load_jumps = false;        ///< other forces on the tissue begin in this step
};

/// Throws NumericalError: a mean condition whose dofs are all held.
[[noreturn]] void throw_all_held();

}  // namespace stylet
