// What must hold after every step of every run.
#pragma once

#include "stylet/simulation/simulation.hpp"

#include <set>
#include <string>
#include <vector>

namespace stylet::robustness {

class Watch {
 public:
  explicit Watch(const Simulation& simulation);

  /// Breaches since the last call, in words.
  [[nodiscard]] std::vector<std::string> look(const Simulation& simulation, const StepRecord& step);

 private:
  void look_at_mesh(const Simulation& simulation);
  void look_at_needle(const Simulation& simulation, const StepRecord& step);
  void breach(const std::string& what) { breaches_.push_back(what); }

  double area_;
  std::set<int> held_;  ///< nodes of supports, which go before the needle
  std::set<int>
      attached_;  ///< at the last look; a node that joins later is on the axis a step later
  std::vector<std::string> breaches_;
};

}  // namespace stylet::robustness
