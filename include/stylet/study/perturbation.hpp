// What becomes of a small disturbance of tissue whose mesh and constraints stand still: the stable
// step and the growth of energy as the real integrators show them, without any formula.
//
// Tissue is linear, so a disturbance of a motion obeys the homogeneous problem: constraints at zero
// and no forces, the constant ones of friction and cutting included.
#pragma once

#include "stylet/dynamics/parameters.hpp"
#include "stylet/fem/tissue_operator.hpp"
#include "stylet/simulation/model.hpp"
#include "stylet/solvers/constraint_set.hpp"

#include <memory>

namespace stylet {

/// Collective. A tissue of its own for an edited state `now` of the mesh `original`; cells that
/// cover several regions mix their materials as in the run.
[[nodiscard]] std::unique_ptr<TissueOperator> tissue_at(MPI_Comm comm,
                                                        const NumberedMesh& original,
                                                        const Mesh& now,
                                                        const TissueParameters& parameters);

/// The same dofs and mean held at zero, without forces.
[[nodiscard]] ConstraintSet homogeneous(ConstraintSet constraints);

/// Collective. Random velocities within +-1 mm/s that respect the constraints. The same on any
/// number of ranks: drawn in the order of the mesh's source.
[[nodiscard]] OwnedVec random_velocities(const TissueOperator& tissue,
                                         const NumberedMesh& original,
                                         const ConstraintSet& constraints);

/// Bisection ends when the stable and the growing step are this close.
inline constexpr double limit_accuracy = 1e-3;

struct MeasuredLimit {
  double predicted = 0;  ///< stable step of ExplicitNewmark without a safety factor (s)
  double step = 0;       ///< measured (s)
};

/// Collective. The largest step of ExplicitNewmark under which the velocities do not grow, by
/// bisection; needs a lumped operator and homogeneous constraints. Throws NumericalError if there is
/// none.
[[nodiscard]] MeasuredLimit measured_limit(TissueOperator& tissue,
                                           const Mesh& mesh,
                                           const ConstraintSet& constraints,
                                           Vec velocities);

/// Kinetic plus strain energy over that of the start.
struct EnergyGrowth {
  double largest = 0;
  double last = 0;
  bool grows = false;  ///< the second half of the run goes above the start
};

/// Collective. Free motion by ImplicitNewmark in n_steps steps of h (s).
[[nodiscard]] EnergyGrowth energy_growth(TissueOperator& tissue,
                                         const Mesh& mesh,
                                         const ConstraintSet& constraints,
                                         Vec velocities,
                                         const TimeParameters& time,
                                         double h,
                                         int n_steps);

}  // namespace stylet
