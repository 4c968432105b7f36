// Stress and energy of a cell, for what shows a run.
#pragma once

#include "stylet/fem/material.hpp"
#include "stylet/simulation/simulation.hpp"

#include <span>

namespace stylet {

struct CellStress {
  Stress stress;              ///< in the scene's frame (Pa)
  double pressure = 0;        ///< lambda tr(eps), averaged as the formulation does (Pa)
  double energy_density = 0;  ///< J/m^3
};

/// cell: of the simulation's mesh; u: displacements of all dofs (m); known: of the same u, from cell to cell.
[[nodiscard]] CellStress stress_in(const Simulation& simulation,
                                   int cell,
                                   std::span<const double> u,
                                   PatchPressures& known);

}  // namespace stylet
