#include "stylet/mesh/box.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/mesh/mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>

namespace stylet {

namespace {

constexpr const char* source = "box";
const std::vector<std::string> side_names = {"left", "right", "bottom", "top", "back", "front"};

[[noreturn]] void fail(const std::string& message) {
  throw InputError(source + (": " + message));
}

void check_names(const BoxMesh& p) {
  std::vector<std::string> regions = {p.region};
  std::vector<std::string> surfaces = side_names;
  for (const auto& region : p.inner_regions) {
    regions.push_back(region.name);
    surfaces.push_back(region.name + "_outline");
  }
  for (auto* names : {&regions, &surfaces}) {
    std::ranges::sort(*names);
    if (names->front().empty()) fail("a region has no name");
    const auto twice = std::ranges::adjacent_find(*names);
    if (twice != names->end()) fail("the name '" + *twice + "' is given twice");
  }
}

void check(const BoxMesh& p) {
  constexpr double most_jitter = 0.3;  // two neighbours may approach by 0.6 of the spacing
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  for (const auto& [name, value] :
       {std::pair("width", p.width), {"height", p.height}, {"depth", p.depth}}) {
    if (!positive(value)) fail(std::string(name) + " = " + exact(value) + "; allowed: above 0 m");
  }
  for (const auto& [name, value] :
       {std::pair("columns", p.columns), {"rows", p.rows}, {"layers", p.layers}}) {
    if (value < 1) fail(std::string(name) + " = " + std::to_string(value) + "; allowed: 1 or more");
  }
  const double n_entries = 24.0 * p.columns * p.rows * p.layers;
  if (n_entries > std::numeric_limits<int>::max()) {
    fail(std::to_string(p.columns) + " columns, " + std::to_string(p.rows) + " rows and " +
         std::to_string(p.layers) + " layers make too many tetrahedra");
  }
  if (!(p.jitter >= 0 && p.jitter < most_jitter)) {
    fail("jitter = " + exact(p.jitter) + "; allowed: 0 or more, below " + exact(most_jitter));
  }
  check_names(p);
  for (const auto& [name, e] : p.inner_regions) {
    if (!positive(e.width) || !positive(e.height) || !positive(e.depth)) {
      fail("region '" + name + "': ellipsoid of " + exact(e.width) + " x " + exact(e.height) +
           " x " + exact(e.depth) + " m; allowed: all above 0");
    }
    const double same = 1e-9 * (p.width + p.height + p.depth);
    const auto reaches_out = [&](double centre, double size, double from, double extent) {
      return centre - size / 2 < from - same || centre + size / 2 > from + extent + same;
    };
    if (reaches_out(e.centre.x, e.width, p.origin.x, p.width) ||
        reaches_out(e.centre.y, e.height, p.origin.y, p.height) ||
        reaches_out(e.centre.z, e.depth, p.origin.z, p.depth)) {
      fail("region '" + name + "' reaches out of the box; allowed: inside it");
    }
  }
}

class Grid {
 public:
  explicit Grid(const BoxMesh& p) : p_(p) {}

  MeshData make() {
    mesh_.dim = 3;
    mesh_.source = source;
    add_nodes();
    for (int k = 0; k < p_.layers; ++k) {
      for (int j = 0; j < p_.rows; ++j) {
        for (int i = 0; i < p_.columns; ++i) add_brick({i, j, k});
      }
    }
    mesh_.region_names = {p_.region};
    mesh_.cell_region.assign(mesh_.cells.size() / 4, 0);
    mesh_.curve_names = side_names;
    const std::array<int, 3> n{p_.columns, p_.rows, p_.layers};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      add_side(n, axis, 0);
      add_side(n, axis, n[axis]);
    }
    return std::move(mesh_);
  }

 private:
  using Place = std::array<int, 3>;

  [[nodiscard]] int node(const Place& at) const {
    return (at[2] * (p_.rows + 1) + at[1]) * (p_.columns + 1) + at[0];
  }

  void add_nodes() {
    std::mt19937 random(static_cast<std::uint32_t>(p_.seed));
    // std::uniform_real_distribution differs between libraries; this does not.
    const auto uniform = [&random] { return 2 * (static_cast<double>(random()) * 0x1p-32) - 1; };
    const auto at = [&](int i, int n, double from, double extent) {
      const double shift = p_.jitter > 0 ? p_.jitter * uniform() : 0.0;
      return from + extent * (i + (i > 0 && i < n ? shift : 0.0)) / n;
    };
    for (int k = 0; k <= p_.layers; ++k) {
      for (int j = 0; j <= p_.rows; ++j) {
        for (int i = 0; i <= p_.columns; ++i) {
          mesh_.coordinates.push_back(at(i, p_.columns, p_.origin.x, p_.width));
          mesh_.coordinates.push_back(at(j, p_.rows, p_.origin.y, p_.height));
          mesh_.coordinates.push_back(at(k, p_.layers, p_.origin.z, p_.depth));
        }
      }
    }
  }

  // A tetrahedron for each order in which one can walk along the three axes from one end of the diagonal
  // to the other. Bricks are mirrored in their neighbours.
  void add_brick(const Place& low) {
    constexpr std::size_t orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},  // right-handed
                                          {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    const bool mirrored = (low[0] + low[1] + low[2]) % 2 == 1;
    for (std::size_t order = 0; order < 6; ++order) {
      Place at = low;
      for (std::size_t k = 0; k < 3; ++k) at[k] += low[k] % 2;
      std::array<int, 4> corners{node(at)};
      for (std::size_t step = 0; step < 3; ++step) {
        const std::size_t axis = orders[order][step];
        at[axis] += low[axis] % 2 == 0 ? 1 : -1;
        corners[step + 1] = node(at);
      }
      if ((order >= 3) != mirrored) std::swap(corners[2], corners[3]);
      mesh_.cells.insert(mesh_.cells.end(), corners.begin(), corners.end());
    }
  }

  // Triangles of the side where this axis is at `level`, outward.
  void add_side(const Place& n, std::size_t axis, int level) {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    Place at{};
    at[axis] = level;
    for (at[v] = 0; at[v] < n[v]; ++at[v]) {
      for (at[u] = 0; at[u] < n[u]; ++at[u]) {
        Place along_u = at, along_v = at, far = at;
        ++along_u[u], ++along_v[v], ++far[u], ++far[v];
        std::array<int, 4> ring{node(at), node(along_u), node(far), node(along_v)};
        if ((at[u] + at[v]) % 2 == 1) std::ranges::rotate(ring, ring.begin() + 1);  // its diagonal
        const auto [a, b, c, d] = ring;
        if (level > 0) {
          mesh_.facets.insert(mesh_.facets.end(), {a, b, c, a, c, d});
        } else {
          mesh_.facets.insert(mesh_.facets.end(), {a, c, b, a, d, c});
        }
        const int side = static_cast<int>(2 * axis) + (level > 0 ? 1 : 0);
        mesh_.facet_curve.insert(mesh_.facet_curve.end(), 2, side);
      }
    }
  }

  const BoxMesh& p_;
  MeshData mesh_;
};

bool is_inside(const Ellipsoid& e, ReferencePlace p) {
  const double x = 2 * (p.x - e.centre.x) / e.width;
  const double y = 2 * (p.y - e.centre.y) / e.height;
  const double z = 2 * (p.z - e.centre.z) / e.depth;
  return x * x + y * y + z * z < 1;
}

/// Gives the tetrahedra inside the ellipsoid to the region, and its rim the name `<region>_outline`.
void add_region(const Mesh& mesh, const SolidRegion& region, MeshData& data) {
  constexpr double allowed = 0.05;  // of the volume
  const int index = static_cast<int>(data.region_names.size());
  const int surface = static_cast<int>(data.curve_names.size());
  data.region_names.push_back(region.name);
  data.curve_names.push_back(region.name + "_outline");
  std::vector<bool> inside(static_cast<std::size_t>(mesh.n_cells()));
  double volume = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto t = mesh.tetrahedron(c);
    const ReferencePlace centre = t[0] + 0.25 * ((t[1] - t[0]) + (t[2] - t[0]) + (t[3] - t[0]));
    if (!is_inside(region.ellipsoid, centre)) continue;
    inside[static_cast<std::size_t>(c)] = true;
    volume += mesh.cell_measure(c);
    data.cell_region[static_cast<std::size_t>(c)] = index;
  }
  constexpr std::size_t faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};  // outward
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (!inside[static_cast<std::size_t>(c)]) continue;
    const auto nodes = mesh.cell(c);
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const auto other = mesh.beyond(c, corner);
      if (other && inside[static_cast<std::size_t>(*other)]) continue;
      for (const std::size_t k : faces[corner]) data.facets.push_back(nodes[k]);
      data.facet_curve.push_back(surface);
    }
  }
  const Ellipsoid& e = region.ellipsoid;
  const double wanted = std::numbers::pi / 6 * e.width * e.height * e.depth;
  if (std::abs(volume - wanted) <= allowed * wanted) return;
  fail("region '" + region.name + "' covers " + ten_digits(volume) + " m3 instead of " +
       ten_digits(wanted) +
       "; allowed: 5 % apart; the grid is too coarse: raise columns, rows and "
       "layers");
}

}  // namespace

MeshData make_box(const BoxMesh& parameters) {
  check(parameters);
  MeshData data = Grid(parameters).make();
  const Mesh mesh(data);
  constexpr double least = 0.1;  // flatter ones spoil the condition of the stiffness matrix
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (mesh.cell_quality(c) > least) continue;
    fail("a tetrahedron has quality " + ten_digits(mesh.cell_quality(c)) + "; allowed: above " +
         ten_digits(least) + "; make the bricks more nearly cubes" +
         (parameters.jitter > 0 ? ", or lower jitter" : ""));
  }
  for (const auto& region : parameters.inner_regions) add_region(mesh, region, data);
  return data;
}

}  // namespace stylet
