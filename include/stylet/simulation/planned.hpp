// What a plan proposes, to be drawn over the tissue.
#pragma once

#include "stylet/geometry/points.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/scene/scene.hpp"

#include <string>
#include <vector>

namespace stylet {

/// In the scene's frame.
struct PlannedSeedPlace {
  std::string target;
  WorldPoint tip;  ///< where the needle's tip is to stand when the seed is left
};

struct PlannedWay {
  std::string needle;
  double height = 0;  ///< m, across the needle
  WorldPoint skin;    ///< where it enters the undeformed tissue
  WorldPoint deepest;
  std::vector<PlannedSeedPlace> seeds;
};

/// plan: planned.yaml of `stylet plan` or any scene with needles, as loaded; mesh: of a Simulation
/// of the same tissue. Throws InputError where a way misses the tissue.
[[nodiscard]] std::vector<PlannedWay> ways_of(const Scene& plan, const Mesh& mesh);

}  // namespace stylet
