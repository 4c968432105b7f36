#include "stylet/simulation/picture.hpp"

#include "stylet/geometry/rotation.hpp"

#include <algorithm>

namespace stylet {

Picture picture_of(const Scene& scene, const Mesh& mesh) {
  const Rotation turn(scene.needle_angle);
  ReferencePoint low = turn.to_scene(mesh.point(0));
  ReferencePoint high = low;
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const auto x = turn.to_scene(mesh.point(node));
    low = {std::min(low.x, x.x), std::min(low.y, x.y)};
    high = {std::max(high.x, x.x), std::max(high.y, x.y)};
  }
  return {1, 1, 1, {128}, low, high - low};
}

}  // namespace stylet
