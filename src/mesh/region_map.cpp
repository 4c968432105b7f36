#include "stylet/mesh/region_map.hpp"

#include "stylet/mesh/embedded_point.hpp"

#include <algorithm>
#include <array>

namespace stylet {

std::vector<std::pair<int, double>> RegionMap::shares(const Mesh& mesh, int cell) const {
  constexpr int n = 8;  // n^2 congruent pieces, sampled at their centroids
  const auto nodes = mesh.cell(cell);
  std::array<ReferencePoint, 3> corner{};
  for (std::size_t i = 0; i < 3; ++i) corner[i] = mesh.point(nodes[i]);
  std::vector<std::pair<int, double>> shares;
  int hint = cell;  // edits keep cells near their place, so the walk is short
  const auto sample = [&](double l1, double l2) {
    const ReferencePoint x =
        corner[0] + l1 * (corner[1] - corner[0]) + l2 * (corner[2] - corner[0]);
    const auto found = locate(initial_, x, hint);
    if (found) hint = found->cell;
    const int region = initial_.region(hint);
    const auto at = std::ranges::find(shares, region, &std::pair<int, double>::first);
    if (at == shares.end()) {
      shares.emplace_back(region, 1.0 / (n * n));
    } else {
      at->second += 1.0 / (n * n);
    }
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      sample((i + 1.0 / 3) / n, (j + 1.0 / 3) / n);
      if (i + j < n - 1) sample((i + 2.0 / 3) / n, (j + 2.0 / 3) / n);
    }
  }
  return shares;
}

}  // namespace stylet
