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

/// A gland with a membrane in other tissue, without damping, needles and time.
inline const std::string two_regions = R"(
mesh:
  rectangle:
    size: [8 cm, 6 cm]
    columns: 16
    rows: 12
    region: surrounding
    inner_regions:
      - {name: gland, polygon: [[2 cm, 2 cm], [5 cm, 2 cm], [5 cm, 4 cm], [2 cm, 4 cm]]}
tissue:
  plane: stress
  regions:
    gland: {youngs_modulus: 60 kPa, poisson_ratio: 0.4, density: 1000 kg/m^3}
    surrounding: {youngs_modulus: 50 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
supports: {left: fixed, top: fixed, bottom: fixed}
membrane: {region: gland, puncture_force: 2 N}
)";

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
