#include "stylet/needle/track.hpp"

#include <algorithm>

namespace stylet {

bool Track::holds(int node) const {
  return std::ranges::find(nodes_, node, &ShaftNode::node) != nodes_.end();
}

bool Track::has_edge(int a, int b) const {
  const auto consecutive = [&](const ShaftNode& x, const ShaftNode& y) {
    return (x.node == a && y.node == b) || (x.node == b && y.node == a);
  };
  return std::ranges::adjacent_find(nodes_, consecutive) != nodes_.end();
}

std::vector<double> Track::distances(const Mesh& mesh) const {
  std::vector<double> s(nodes_.size(), 0.0);
  for (std::size_t i = nodes_.size(); i-- > 1;) {
    s[i - 1] = s[i] + distance(mesh.point(nodes_[i - 1].node), mesh.point(nodes_[i].node));
  }
  return s;
}

std::vector<double> Track::lengths(const Mesh& mesh, double from, double to) const {
  const auto s = distances(mesh);
  std::vector<double> lengths(nodes_.size(), 0.0);
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
    const double deep = s[i + 1];
    const double length = s[i] - deep;
    const double a = std::max(from, deep);
    const double b = std::min(to, s[i]);
    if (!(b > a) || !(length > 0)) continue;
    // Hat function of the node towards the skin: (x - deep) / length.
    const double skin_part = ((b - deep) * (b - deep) - (a - deep) * (a - deep)) / (2 * length);
    const bool deep_attached = nodes_[i + 1].attached;
    lengths[i] += deep_attached ? skin_part : b - a;
    if (deep_attached) lengths[i + 1] += (b - a) - skin_part;
  }
  return lengths;
}

}  // namespace stylet
