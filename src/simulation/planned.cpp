#include "stylet/simulation/planned.hpp"

#include "stylet/geometry/rotation.hpp"
#include "stylet/needle/advance.hpp"
#include "stylet/needle/stops.hpp"

#include <algorithm>

namespace stylet {

std::vector<PlannedWay> ways_of(const Scene& plan, const Mesh& mesh) {
  const Rotation turn(plan.needle_angle);
  std::vector<PlannedWay> ways;
  for (const NeedleParameters& needle : plan.needles) {
    const Axis axis{needle.height};
    const double skin = Axis::along(find_entry(mesh, axis, needle.name).x);
    const auto point = [&](double along) { return turn.to_scene(axis.at<WorldFrame>(along)); };
    PlannedWay way{needle.name, needle.height, point(skin), {}, {}};
    double deepest = skin;
    const auto travels = travels_of(needle.motion, Axis::along_sign);
    for (std::size_t i = 0; i < travels.size(); ++i) {
      const double tip = along_of(travels[i].to, skin);
      deepest = std::max(deepest, tip);
      if (needle.motion[i].kind != ActionKind::implant) continue;
      way.seeds.push_back({needle.motion[i].target, point(tip)});
    }
    way.deepest = point(deepest);
    ways.push_back(std::move(way));
  }
  return ways;
}

}  // namespace stylet
