#include "stylet/mesh/region_map.hpp"

#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/embedded_point.hpp"

#include <algorithm>
#include <array>

namespace stylet {

namespace {

using Triangle = std::array<ReferencePoint, 3>;

Triangle corners(const Mesh& mesh, int cell) {
  const auto n = mesh.cell(cell);
  return {mesh.point(n[0]), mesh.point(n[1]), mesh.point(n[2])};
}

// The part of a convex polygon to the left of the line from a to b.
std::vector<ReferencePoint> left_of(const std::vector<ReferencePoint>& polygon,
                                    ReferencePoint a,
                                    ReferencePoint b) {
  std::vector<ReferencePoint> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto& p = polygon[i];
    const auto& q = polygon[(i + 1) % polygon.size()];
    const double sp = cross(b - a, p - a);
    const double sq = cross(b - a, q - a);
    if (sp >= 0) kept.push_back(p);
    if ((sp < 0) != (sq < 0)) kept.push_back(p + (sp / (sp - sq)) * (q - p));
  }
  return kept;
}

/// Area that two triangles share; none where they do not even touch.
std::optional<double> common_area(const Triangle& a, const Triangle& b) {
  std::vector<ReferencePoint> polygon(a.begin(), a.end());
  for (std::size_t i = 0; i < 3; ++i) polygon = left_of(polygon, b[i], b[(i + 1) % 3]);
  if (polygon.empty()) return std::nullopt;
  double area = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    area += signed_area(polygon[0], polygon[i - 1], polygon[i]);
  }
  return area;
}

}  // namespace

std::vector<std::pair<int, double>> RegionMap::shares(const Mesh& mesh, int cell) const {
  const Triangle triangle = corners(mesh, cell);
  const ReferencePoint middle = triangle[0] + (1.0 / 3) * (triangle[1] - triangle[0]) +
                                (1.0 / 3) * (triangle[2] - triangle[0]);
  const auto found = locate(initial_, middle, cell);  // edits keep cells near their place
  std::vector<int> below{found ? found->cell : cell};
  std::vector<std::pair<int, double>> shares;
  double total = 0;
  for (std::size_t i = 0; i < below.size(); ++i) {
    const auto area = common_area(triangle, corners(initial_, below[i]));
    if (!area) continue;
    const int region = initial_.region(below[i]);
    const auto at = std::ranges::find(shares, region, &std::pair<int, double>::first);
    if (at == shares.end()) {
      shares.emplace_back(region, *area);
    } else {
      at->second += *area;
    }
    total += *area;
    const auto n = initial_.cell(below[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto next = initial_.across(below[i], n[k], n[(k + 1) % 3]);
      if (next && std::ranges::find(below, *next) == below.end()) below.push_back(*next);
    }
  }
  // Cells that only touch share round-off.
  constexpr double nothing = 1e-12;
  std::erase_if(shares, [&](const auto& share) { return share.second <= nothing * total; });
  if (shares.size() <= 1) return {{shares.empty() ? initial_.region(cell) : shares[0].first, 1.0}};
  total = 0;
  for (const auto& share : shares) total += share.second;
  for (auto& share : shares) share.second /= total;
  return shares;
}

}  // namespace stylet
