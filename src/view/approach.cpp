#include "stylet/view/approach.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/simulation/needle_path.hpp"

#include <algorithm>
#include <utility>

namespace stylet {

Approach approach_of(const Simulation& simulation, NeedleParameters needle) {
  // Short of the far side by the length that the tip spreads its force over, and a twentieth of the way.
  constexpr double share = 0.05;
  Approach approach;
  try {
    Scene scene = simulation.scene();
    Action insert;
    insert.kind = ActionKind::insert;
    insert.speed = 1;
    insert.depth = 0;
    needle.motion = {insert};
    scene.needles = {std::move(needle)};
    const NeedlePath path = find_path(scene, simulation.mesh(), 0);
    approach.skin = path.skin;
    const double margin = std::max(scene.needles[0].cutting.tip_length, share * path.end);
    const double depth = std::max(0.0, path.end - margin);
    approach.deepest = path.skin + depth;
    scene.needles[0].motion[0].depth = depth;
    check_needles(scene, simulation.mesh(), simulation.body().conditions());
  } catch (const InputError& error) {
    approach.obstacle = error.what();
  }
  return approach;
}

}  // namespace stylet
