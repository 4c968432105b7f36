#include "stylet/mesh/mesh.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/quadratic.hpp"

#include <algorithm>
#include <limits>

namespace stylet {

namespace {

std::uint64_t edge_key(int a, int b) {
  const auto [low, high] = std::minmax(a, b);
  return (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint32_t>(high);
}

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

}  // namespace

Mesh::Mesh(MeshData data) : data_(std::move(data)) {
  const auto n = static_cast<std::size_t>(n_nodes());
  around_.resize(n);
  for (int c = 0; c < n_cells(); ++c) {
    if (!(cell_measure(c) > 0)) {
      throw InputError(data_.source + ": cell " + std::to_string(c + 1) +
                       " is inverted or has no " + (dim() == 2 ? "area" : "volume"));
    }
    for (const int node : nodes(c)) around_[static_cast<std::size_t>(node)].push_back(c);
  }
  on_boundary_.assign(n, 0);
  for (int c = 0; c < n_cells(); ++c) {
    const auto all = nodes(c);
    const auto n_corners = cell(c).size();
    for (std::size_t i = 0; i < n_corners; ++i) {
      if (beyond(c, i)) continue;
      for (std::size_t k = 0; k < all.size(); ++k) {
        const bool apart = k < n_corners ? k == i : is_of_edge(k - n_corners, i);
        if (!apart) on_boundary_[static_cast<std::size_t>(all[k])] = 1;
      }
    }
  }
  locked_ = on_boundary_;
}

void Mesh::lock_curve(const std::string& curve) {
  for (const int f : facets_of(curve)) {
    const auto nodes = facet_nodes(f);
    if (dim() == 2) locked_edges_.push_back(edge_key(nodes[0], nodes[1]));
    for (const int node : nodes) locked_[static_cast<std::size_t>(node)] = 1;
  }
  std::ranges::sort(locked_edges_);
}

std::vector<int> Mesh::neighbours(int node) const {
  std::vector<int> nodes;
  for (const int c : cells_around(node)) {
    for (const int other : this->nodes(c)) nodes.push_back(other);
  }
  sort_unique(nodes);
  return nodes;
}

std::vector<int> Mesh::cells_with(int a, int b) const {
  std::vector<int> both;
  std::ranges::set_intersection(cells_around(a), cells_around(b), std::back_inserter(both));
  return both;
}

std::optional<int> Mesh::across(int c, int a, int b) const {
  const auto around_a = cells_around(a);
  const auto around_b = cells_around(b);
  for (const int other : around_a) {
    if (other != c && std::ranges::binary_search(around_b, other)) return other;
  }
  return std::nullopt;
}

std::optional<int> Mesh::beyond(int c, std::size_t corner) const {
  const auto nodes = cell(c);
  if (dim() == 2) return across(c, nodes[(corner + 1) % 3], nodes[(corner + 2) % 3]);
  const auto around_b = cells_around(nodes[(corner + 2) % 4]);
  const auto around_d = cells_around(nodes[(corner + 3) % 4]);
  for (const int other : cells_around(nodes[(corner + 1) % 4])) {
    if (other != c && std::ranges::binary_search(around_b, other) &&
        std::ranges::binary_search(around_d, other)) {
      return other;
    }
  }
  return std::nullopt;
}

int Mesh::opposite(int c, int a, int b) const {
  for (const int node : cell(c)) {
    if (node != a && node != b) return node;
  }
  return -1;
}

bool Mesh::is_locked_edge(int a, int b) const {
  const auto both = cells_with(a, b);
  if (both.size() != 2 || region(both[0]) != region(both[1])) return true;
  return std::ranges::binary_search(locked_edges_, edge_key(a, b));
}

std::vector<int> Mesh::facets_of(const std::string& curve) const {
  const auto found = std::ranges::find(data_.curve_names, curve);
  if (found == data_.curve_names.end()) {
    const auto stray = std::ranges::find(data_.stray_curves, curve, &StrayCurve::name);
    if (stray != data_.stray_curves.end()) throw InputError(stray->fault);
    throw InputError(data_.source + ": no " + (dim() == 2 ? "curve" : "surface") + " named '" +
                     curve + "'; the mesh has: " + list(data_.curve_names));
  }
  const int index = static_cast<int>(found - data_.curve_names.begin());
  std::vector<int> facets;
  for (int f = 0; f < data_.n_facets(); ++f) {
    if (data_.facet_curve[static_cast<std::size_t>(f)] == index) facets.push_back(f);
  }
  return facets;
}

std::vector<int> Mesh::nodes_of(const std::string& curve) const {
  std::vector<int> nodes;
  for (const int f : facets_of(curve)) {
    const auto of_facet = facet_nodes(f);
    nodes.insert(nodes.end(), of_facet.begin(), of_facet.end());
  }
  sort_unique(nodes);
  return nodes;
}

int Mesh::region_index(const std::string& name) const {
  const auto found = std::ranges::find(data_.region_names, name);
  if (found == data_.region_names.end()) {
    throw InputError(data_.source + ": no region named '" + name +
                     "'; the mesh has: " + list(data_.region_names));
  }
  return static_cast<int>(found - data_.region_names.begin());
}

double Mesh::cell_measure(int c) const {
  if (dim() == 3) return signed_volume(tetrahedron(c));
  const auto nodes = cell(c);
  return signed_area(point(nodes[0]), point(nodes[1]), point(nodes[2]));
}

double Mesh::facet_measure(int f) const {
  const auto nodes = facet(f);
  if (dim() == 2) return distance(point(nodes[0]), point(nodes[1]));
  const ReferencePlace a = place(nodes[0]);
  return 0.5 * norm(cross(place(nodes[1]) - a, place(nodes[2]) - a));
}

double Mesh::cell_quality(int c) const {
  if (dim() == 3) return quality(tetrahedron(c));
  const auto nodes = cell(c);
  return quality(point(nodes[0]), point(nodes[1]), point(nodes[2]));
}

double Mesh::worst_quality(std::span<const int> cells) const {
  double worst = std::numeric_limits<double>::infinity();
  for (const int c : cells) worst = std::min(worst, cell_quality(c));
  return worst;
}

void Mesh::move_node(int node, ReferencePoint to) {
  const auto at = 2 * static_cast<std::size_t>(node);
  data_.coordinates[at] = to.x;
  data_.coordinates[at + 1] = to.y;
  ++version_;
}

std::vector<int> Mesh::put_back(const MeshData& source) {
  std::vector<int> changed;
  const auto differs = [](auto a, auto b) { return !std::ranges::equal(a, b); };
  for (int node = 0; node < n_nodes(); ++node) {
    const auto dim = static_cast<std::size_t>(data_.dim);
    const std::span before(source.coordinates.data() + dim * static_cast<std::size_t>(node), dim);
    if (!differs(coordinates(node), before)) continue;
    const auto around = cells_around(node);
    changed.insert(changed.end(), around.begin(), around.end());
  }
  std::vector<int> rewired;
  for (int c = 0; c < n_cells(); ++c) {
    const auto width = static_cast<std::size_t>(data_.dim) + 1;
    const std::span before(source.cells.data() + width * static_cast<std::size_t>(c), width);
    if (differs(cell(c), before)) rewired.push_back(c);
  }
  changed.insert(changed.end(), rewired.begin(), rewired.end());
  const auto around = [&](int node) -> std::vector<int>& {
    return around_[static_cast<std::size_t>(node)];
  };
  for (const int c : rewired) {
    for (const int node : cell(c)) std::erase(around(node), c);
  }
  data_.coordinates = source.coordinates;
  data_.cells = source.cells;
  for (const int c : rewired) {
    for (const int node : cell(c)) {
      around(node).insert(std::ranges::lower_bound(around(node), c), c);
    }
  }
  sort_unique(changed);
  if (!changed.empty()) ++version_;
  if (!rewired.empty()) ++connectivity_version_;
  return changed;
}

std::array<int, 2> Mesh::flip_edge(int a, int b) {
  const auto both = cells_with(a, b);
  const int c = opposite(both[0], a, b);
  const int d = opposite(both[1], a, b);
  // Orient so that both[0] = (a, b, c) counter-clockwise; then the new pair is (a, d, c), (d, b, c).
  const auto nodes = cell(both[0]);
  const auto at = static_cast<std::size_t>(std::ranges::find(nodes, a) - nodes.begin());
  const bool forward = nodes[(at + 1) % 3] == b;
  const int first = forward ? a : b;
  const int second = forward ? b : a;
  const auto set = [&](int index, std::array<int, 3> corners) {
    std::ranges::copy(corners, data_.cells.begin() + static_cast<std::ptrdiff_t>(index) * 3);
  };
  set(both[0], {first, d, c});
  set(both[1], {d, second, c});
  const auto remove = [&](int node, int cell) {
    auto& list = around_[static_cast<std::size_t>(node)];
    list.erase(std::ranges::find(list, cell));
  };
  const auto insert = [&](int node, int cell) {
    auto& list = around_[static_cast<std::size_t>(node)];
    list.insert(std::ranges::lower_bound(list, cell), cell);
  };
  remove(second, both[0]);
  remove(first, both[1]);
  insert(d, both[0]);
  insert(c, both[1]);
  ++version_;
  ++connectivity_version_;
  return {c, d};
}

}  // namespace stylet
