// What may change while a simulation runs.
#pragma once

#include "stylet/simulation/simulation.hpp"

#include <string>
#include <vector>

namespace stylet {

/// A number that Simulation::change takes.
struct Changeable {
  std::string key;  ///< such as needle.cutting.cutting_force, tissue.regions.NAME.youngs_modulus
  std::string doc;
  std::string unit;    ///< SI; empty: none
  double value = 0;    ///< now
  double minimum = 0;  ///< as the scene's key has it; may be infinite
  double maximum = 0;
  bool above_minimum = false;  ///< the minimum itself is not allowed
  bool below_maximum = false;
  bool new_operator = false;  ///< the tissue's matrices are made anew
};

/// Those of the present needle only if one has entered.
[[nodiscard]] std::vector<Changeable> changeable(const Simulation& simulation);

/// Of a needle that has not entered; the keys are those of one that has.
[[nodiscard]] std::vector<Changeable> changeable(NeedleParameters needle);
/// As Simulation::change, before it enters.
void change(const Scene& scene, NeedleParameters& needle, const std::string& key, double value);

}  // namespace stylet
