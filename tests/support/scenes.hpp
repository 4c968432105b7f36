// Scenes for tests: the reference scene and small ones from YAML, run to their end.
#pragma once

#include "stylet/scene/loader.hpp"
#include "stylet/simulation/simulation.hpp"

#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace stylet {

/// input/prostate.yaml in steps of 10 ms until the seed is implanted, then the overrides.
inline Scene reference_scene(const std::vector<std::string>& overrides = {}) {
  const std::string file = STYLET_SOURCE_DIR "/input/prostate.yaml";
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  std::vector<std::string> all{"time.step=10 ms", "time.until=implanted"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  return load_scene(file, text.str(), all);
}

inline Scene scene_of(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  return load_scene("test.yaml", yaml, overrides);
}

/// each: called with the simulation and the record of every step.
template <class Each>
void run_to_end(Simulation& simulation, Each&& each) {
  while (!simulation.done()) {
    const StepRecord record = simulation.step();
    each(record);
  }
}

inline void run_to_end(Simulation& simulation) {
  run_to_end(simulation, [](const StepRecord&) {});
}

/// Placement error of the first seed (m).
inline double placement_error(const Scene& scene) {
  Simulation simulation(MPI_COMM_WORLD, scene, false);
  run_to_end(simulation);
  return simulation.placement_errors().at(0);
}

}  // namespace stylet
