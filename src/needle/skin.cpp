#include "stylet/needle/skin.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

std::vector<int> boundary_neighbours(const Mesh& mesh, int node) {
  std::vector<int> ends;
  for (const int other : mesh.neighbours(node)) {
    if (other == node || !mesh.on_boundary(other)) continue;
    if (mesh.cells_with(node, other).size() == 1) ends.push_back(other);
  }
  return ends;
}

bool is_corner(const Mesh& mesh, int node) {
  const auto ends = boundary_neighbours(mesh, node);
  if (ends.size() != 2) return true;
  const Vector2 e0 = mesh.point(node) - mesh.point(ends[0]);
  const Vector2 e1 = mesh.point(ends[1]) - mesh.point(node);
  constexpr double straight = 0.5;  // sine of 30 degrees
  return dot(e0, e1) <= 0 || std::abs(cross(e0, e1)) > straight * norm(e0) * norm(e1);
}

Skin::Skin(const Mesh& mesh, int entry, double reach) {
  const auto walk = [&](int next) {
    std::vector<int> nodes;
    int last = entry;
    double length = 0;
    while (length < reach && next != entry) {
      nodes.push_back(next);
      length += distance(mesh.point(last), mesh.point(next));
      if (is_corner(mesh, next)) break;
      const auto ends = boundary_neighbours(mesh, next);
      const int further = ends[0] == last ? ends[1] : ends[0];
      last = next;
      next = further;
    }
    return nodes;
  };
  const auto ends = boundary_neighbours(mesh, entry);
  if (!ends.empty()) nodes_ = walk(ends[0]);
  std::ranges::reverse(nodes_);
  entry_ = nodes_.size();
  nodes_.push_back(entry);
  if (ends.size() != 2) return;
  const auto other = walk(ends[1]);
  nodes_.insert(nodes_.end(), other.begin(), other.end());
}

std::vector<NodeShare> Skin::lengths(const Mesh& mesh, double width) const {
  std::vector<NodeShare> shares{{nodes_[entry_], 0}};
  const auto walk = [&](std::ptrdiff_t direction) {
    double left = 0.5 * width;
    auto at = static_cast<std::ptrdiff_t>(entry_);
    std::size_t own = 0;  // index of the near node's share
    while (left > 0 && at + direction >= 0 && at + direction < std::ssize(nodes_)) {
      const int near = nodes_[static_cast<std::size_t>(at)];
      const int far = nodes_[static_cast<std::size_t>(at + direction)];
      const double edge = distance(mesh.point(near), mesh.point(far));
      const double part = std::min(left, edge);
      const double of_far = 0.5 * part * part / edge;
      shares[own].value += part - of_far;
      own = shares.size();
      shares.push_back({far, of_far});
      left -= part;
      at += direction;
    }
  };
  walk(-1);
  walk(1);
  return shares;
}

}  // namespace stylet
