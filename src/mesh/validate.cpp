#include "stylet/mesh/validate.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/mesh/overlap.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace stylet {

namespace {

/// A side of a cell: an edge in 2D, a face in 3D.
struct Side {
  std::array<int, 3> key;  ///< its nodes in rising order, -1 in the last place in 2D
  int cell;
  bool even;  ///< parity of the sort: two cells on opposite sides see opposite parities
};

class Validator {
 public:
  explicit Validator(MeshData& mesh) : mesh_(mesh), n_corners_(mesh.dim + 1) {}

  void check_sizes() const;
  void check_nodes() const;
  void orient();
  void check_sides();

 private:
  [[nodiscard]] std::string node_number(int node) const {
    return number_in_file(mesh_.origin.node_number, node);
  }
  [[nodiscard]] std::string describe(int cell) const;
  [[nodiscard]] std::string describe_facet(int facet) const;
  /// The source, with the place there of the i-th of these.
  [[nodiscard]] std::string at(const std::vector<std::int64_t>& places, int i) const {
    if (places.empty()) return mesh_.source + ": ";
    return mesh_.source + (mesh_.origin.is_binary ? ": byte " : ":") + std::to_string(places[i]) +
           ": ";
  }
  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(mesh_.source + ": " + message);
  }
  [[noreturn]] void fail_at_cell(int cell, const std::string& message) const {
    throw InputError(at(mesh_.origin.cell_place, cell) + describe(cell) + message);
  }
  [[nodiscard]] double measure(int cell) const;
  [[nodiscard]] double longest_edge(int cell) const;
  [[nodiscard]] int node(int cell, int k) const { return mesh_.cells[n_corners_ * cell + k]; }
  [[nodiscard]] double x(int node, int k) const { return mesh_.coordinates[mesh_.dim * node + k]; }
  [[nodiscard]] Side side_of(const int* nodes, int cell) const;
  [[nodiscard]] std::vector<Side> sorted_sides() const;
  void check_shared(const Side& a, const Side& b) const;
  void check_facets(const std::vector<Side>& sides);

  MeshData& mesh_;
  int n_corners_;
};

std::string Validator::describe(int cell) const {
  std::string text = mesh_.dim == 2 ? "triangle " : "tetrahedron ";
  text += number_in_file(mesh_.origin.cell_number, cell) + " (nodes ";
  for (int k = 0; k < n_corners_; ++k) text += (k > 0 ? ", " : "") + node_number(node(cell, k));
  text += "; first at (";
  for (int k = 0; k < mesh_.dim; ++k) text += (k > 0 ? ", " : "") + exact(x(node(cell, 0), k));
  return text + ") m)";
}

std::string Validator::describe_facet(int facet) const {
  std::string text = "facet " + number_in_file(mesh_.origin.facet_number, facet) + " of '" +
                     mesh_.curve_names[mesh_.facet_curve[facet]] + "' (nodes ";
  for (int k = 0; k < mesh_.dim; ++k) {
    text += (k > 0 ? ", " : "") + node_number(mesh_.facets[mesh_.dim * facet + k]);
  }
  return text + ")";
}

void Validator::check_sizes() const {
  if (mesh_.dim != 2 && mesh_.dim != 3) fail("dimension must be 2 or 3");
  const auto n_cells = static_cast<std::size_t>(mesh_.n_cells());
  const auto n_facets = static_cast<std::size_t>(mesh_.n_facets());
  if (n_cells == 0) fail("the mesh has no cells; at least one is needed");
  if (mesh_.cells.size() != n_cells * n_corners_ || mesh_.cell_region.size() != n_cells ||
      mesh_.coordinates.size() % mesh_.dim != 0 || mesh_.facets.size() != n_facets * mesh_.dim ||
      mesh_.facet_curve.size() != n_facets) {
    fail("the arrays of the mesh do not fit each other");
  }
  const auto outside = [](const std::vector<int>& values, std::size_t n) {
    return std::ranges::any_of(values,
                               [n](int v) { return v < 0 || static_cast<std::size_t>(v) >= n; });
  };
  if (outside(mesh_.cell_region, mesh_.region_names.size())) fail("a cell has no region name");
  if (outside(mesh_.facet_curve, mesh_.curve_names.size())) fail("a facet has no curve name");
}

void Validator::check_nodes() const {
  const int n_nodes = mesh_.n_nodes();
  for (std::size_t i = 0; i < mesh_.cells.size(); ++i) {
    if (mesh_.cells[i] >= 0 && mesh_.cells[i] < n_nodes) continue;
    fail("cell " + std::to_string(i / n_corners_ + 1) + " has node " +
         std::to_string(mesh_.cells[i] + 1) + "; allowed: 1 to " + std::to_string(n_nodes));
  }
  for (std::size_t i = 0; i < mesh_.facets.size(); ++i) {
    if (mesh_.facets[i] >= 0 && mesh_.facets[i] < n_nodes) continue;
    fail("facet " + std::to_string(i / mesh_.dim + 1) + " has node " +
         std::to_string(mesh_.facets[i] + 1) + "; allowed: 1 to " + std::to_string(n_nodes));
  }
  for (std::size_t i = 0; i < mesh_.coordinates.size(); ++i) {
    if (std::isfinite(mesh_.coordinates[i])) continue;
    const int bad = static_cast<int>(i) / mesh_.dim;
    std::string user = "no cell";
    for (int c = 0; c < mesh_.n_cells() && user == "no cell"; ++c) {
      for (int k = 0; k < n_corners_; ++k) {
        if (node(c, k) == bad) user = describe(c);
      }
    }
    fail("node " + node_number(bad) + " has a coordinate that is not finite, used by " + user);
  }
}

/// Area or volume, positive for the right orientation.
double Validator::measure(int cell) const {
  const auto edge = [&](int to, int k) { return x(node(cell, to), k) - x(node(cell, 0), k); };
  if (mesh_.dim == 2) return 0.5 * (edge(1, 0) * edge(2, 1) - edge(1, 1) * edge(2, 0));
  double volume = 0;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const int m = (k + 2) % 3;
    volume += edge(3, k) * (edge(1, l) * edge(2, m) - edge(1, m) * edge(2, l)) / 6;
  }
  return volume;
}

double Validator::longest_edge(int cell) const {
  double longest = 0;
  for (int i = 0; i < n_corners_; ++i) {
    for (int j = 0; j < i; ++j) {
      double squared = 0;
      for (int k = 0; k < mesh_.dim; ++k) {
        const double d = x(node(cell, i), k) - x(node(cell, j), k);
        squared += d * d;
      }
      longest = std::max(longest, squared);
    }
  }
  return std::sqrt(longest);
}

void Validator::orient() {
  // Rounding alone leaves about 1e-16; a cell this flat has no usable gradient in double precision.
  constexpr double flat = 1e-12;
  for (int c = 0; c < mesh_.n_cells(); ++c) {
    const double size = measure(c);
    if (!(std::abs(size) > flat * std::pow(longest_edge(c), mesh_.dim))) {
      fail_at_cell(c, std::string(" is degenerate: its ") + (mesh_.dim == 2 ? "area" : "volume") +
                          " is zero");
    }
    if (size < 0) std::swap(mesh_.cells[n_corners_ * c + 1], mesh_.cells[n_corners_ * c + 2]);
  }
}

Side Validator::side_of(const int* nodes, int cell) const {
  Side side{{nodes[0], nodes[1], mesh_.dim == 3 ? nodes[2] : -1}, cell, true};
  const auto order = [&side](int i, int j) {
    if (side.key[i] <= side.key[j]) return;
    std::swap(side.key[i], side.key[j]);
    side.even = !side.even;
  };
  order(0, 1);
  if (mesh_.dim == 3) {
    order(1, 2);
    order(0, 1);
  }
  return side;
}

std::vector<Side> Validator::sorted_sides() const {
  // Outward sides of a cell with positive measure.
  constexpr int edges[3][2] = {{0, 1}, {1, 2}, {2, 0}};
  constexpr int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  std::vector<Side> sides;
  sides.reserve(mesh_.cells.size());
  for (int c = 0; c < mesh_.n_cells(); ++c) {
    for (int s = 0; s < n_corners_; ++s) {
      const int* local = mesh_.dim == 2 ? edges[s] : faces[s];
      std::array<int, 3> nodes{};
      for (int k = 0; k < mesh_.dim; ++k) nodes[k] = node(c, local[k]);
      sides.push_back(side_of(nodes.data(), c));
    }
  }
  std::ranges::sort(sides, [](const Side& a, const Side& b) {
    return a.key != b.key ? a.key < b.key : a.cell < b.cell;
  });
  return sides;
}

void Validator::check_shared(const Side& a, const Side& b) const {
  const auto sorted = [&](int cell) {
    std::array<int, 4> nodes{-1, -1, -1, -1};
    for (int k = 0; k < n_corners_; ++k) nodes[k] = node(cell, k);
    std::ranges::sort(nodes);
    return nodes;
  };
  if (sorted(a.cell) == sorted(b.cell)) {
    const std::string& region = mesh_.region_names[mesh_.cell_region[a.cell]];
    const std::string& other = mesh_.region_names[mesh_.cell_region[b.cell]];
    fail_at_cell(b.cell, " is a duplicate of " + describe(a.cell) +
                             (region == other ? ""
                                              : ", in regions '" + other + "' and '" + region +
                                                    "'; allowed: one region a cell"));
  }
  if (a.even == b.even) {
    fail_at_cell(b.cell, " overlaps " + describe(a.cell) + ": both lie on the same side of a " +
                             (mesh_.dim == 2 ? "shared edge" : "shared face"));
  }
}

void Validator::check_facets(const std::vector<Side>& sides) {
  struct Facet {
    std::array<int, 3> key;
    int curve;
    int number;
  };
  std::vector<Facet> facets;
  std::map<int, std::string> strays;
  for (int f = 0; f < mesh_.n_facets(); ++f) {
    const auto key =
        side_of(mesh_.facets.data() + static_cast<std::ptrdiff_t>(mesh_.dim) * f, -1).key;
    const auto found = std::ranges::lower_bound(sides, key, {}, &Side::key);
    if (found == sides.end() || found->key != key) {
      strays.try_emplace(
          mesh_.facet_curve[f],
          at(mesh_.origin.facet_place, f) + describe_facet(f) +
              (mesh_.dim == 2 ? " is no edge of a cell; named curves must run along cells"
                              : " is no face of a cell; named surfaces must consist of "
                                "faces of cells"));
    }
    facets.push_back({key, mesh_.facet_curve[f], f});
  }
  std::ranges::sort(facets, [](const Facet& a, const Facet& b) {
    return std::tie(a.key, a.curve, a.number) < std::tie(b.key, b.curve, b.number);
  });
  for (std::size_t i = 1; i < facets.size(); ++i) {
    const Facet& f = facets[i];
    if (f.key != facets[i - 1].key || f.curve != facets[i - 1].curve) continue;
    throw InputError(at(mesh_.origin.facet_place, f.number) + describe_facet(f.number) +
                     " is given twice");
  }
  mesh_.make_stray(strays);
}

void Validator::check_sides() {
  const std::vector<Side> sides = sorted_sides();
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    if (sides[i].key != sides[i + 1].key) continue;
    check_shared(sides[i], sides[i + 1]);
    if (i + 2 < sides.size() && sides[i].key == sides[i + 2].key) {
      check_shared(sides[i], sides[i + 2]);
      check_shared(sides[i + 1], sides[i + 2]);
      fail_at_cell(sides[i + 2].cell,
                   std::string(mesh_.dim == 2 ? " shares an edge" : " shares a face") +
                       " with two others, " + describe(sides[i].cell) + " and " +
                       describe(sides[i + 1].cell) + "; allowed: two cells " +
                       (mesh_.dim == 2 ? "an edge" : "a face"));
    }
  }
  check_facets(sides);
}

}  // namespace

void validate(MeshData& mesh) {
  Validator validator(mesh);
  validator.check_sizes();
  validator.check_nodes();
  validator.orient();
  validator.check_sides();
  mesh.dim == 2 ? check_overlaps(mesh) : check_overlaps_in_space(mesh);
  mesh.origin = {};
}

}  // namespace stylet
