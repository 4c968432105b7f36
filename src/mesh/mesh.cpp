#include "stylet/mesh/mesh.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/geometry/triangle.hpp"

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

double tetrahedron_volume(const Mesh& mesh, std::span<const int> nodes) {
  std::array<std::array<double, 3>, 3> e{};
  const auto x0 = mesh.coordinates(nodes[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto x = mesh.coordinates(nodes[i + 1]);
    for (std::size_t k = 0; k < 3; ++k) e[i][k] = x[k] - x0[k];
  }
  return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
          e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
          e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
         6;
}

}  // namespace

Mesh::Mesh(MeshData data) : data_(std::move(data)) {
  const auto n = static_cast<std::size_t>(n_nodes());
  around_.resize(n);
  for (int c = 0; c < n_cells(); ++c) {
    if (!(cell_measure(c) > 0)) {
      throw InputError(data_.source + ": cell " + std::to_string(c + 1) +
                       " is inverted or has no area");
    }
    for (const int node : cell(c)) around_[static_cast<std::size_t>(node)].push_back(c);
  }
  on_boundary_.assign(n, 0);
  if (dim() == 2) {
    for (int c = 0; c < n_cells(); ++c) {
      const auto nodes = cell(c);
      for (std::size_t i = 0; i < 3; ++i) {
        const int a = nodes[i];
        const int b = nodes[(i + 1) % 3];
        if (across(c, a, b)) continue;
        for (const int node : {a, b}) on_boundary_[static_cast<std::size_t>(node)] = 1;
      }
    }
  }
  locked_ = on_boundary_;
}

void Mesh::lock_curve(const std::string& curve) {
  for (const int f : facets_of(curve)) {
    const int a = data_.facets[2 * static_cast<std::size_t>(f)];
    const int b = data_.facets[2 * static_cast<std::size_t>(f) + 1];
    locked_edges_.push_back(edge_key(a, b));
    for (const int node : {a, b}) locked_[static_cast<std::size_t>(node)] = 1;
  }
  std::ranges::sort(locked_edges_);
}

std::vector<int> Mesh::neighbours(int node) const {
  std::vector<int> nodes;
  for (const int c : cells_around(node)) {
    for (const int other : cell(c)) nodes.push_back(other);
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
    throw InputError(data_.source + ": no curve named '" + curve +
                     "'; the mesh has: " + list(data_.curve_names));
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
  const auto width = static_cast<std::size_t>(dim());
  for (const int f : facets_of(curve)) {
    const auto first = data_.facets.begin() + static_cast<std::ptrdiff_t>(f * width);
    nodes.insert(nodes.end(), first, first + static_cast<std::ptrdiff_t>(width));
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
  const auto nodes = cell(c);
  if (dim() == 3) return tetrahedron_volume(*this, nodes);
  return signed_area(point(nodes[0]), point(nodes[1]), point(nodes[2]));
}

double Mesh::cell_quality(int c) const {
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
    const std::span<const double> before(source.coordinates.data() + std::size_t(2) * node, 2);
    if (!differs(coordinates(node), before)) continue;
    const auto around = cells_around(node);
    changed.insert(changed.end(), around.begin(), around.end());
  }
  std::vector<int> rewired;
  for (int c = 0; c < n_cells(); ++c) {
    const std::span<const int> before(source.cells.data() + std::size_t(3) * c, 3);
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
