#include "stylet/mesh/refine.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/geometry/tetrahedron.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace stylet {

namespace {

using Edge = std::pair<int, int>;

Edge edge(int a, int b) {
  return std::minmax(a, b);
}

/// All edges, sorted: the midpoint of edges[i] is node n_nodes + i.
std::vector<Edge> edges_of(const MeshData& mesh) {
  std::vector<Edge> edges;
  edges.reserve(mesh.cells.size() + mesh.facet_curve.size());
  const auto add = [&](const std::vector<int>& simplices, int width) {
    for (std::size_t at = 0; at < simplices.size(); at += static_cast<std::size_t>(width)) {
      for (int i = 0; i < width; ++i) {
        for (int j = 0; j < i; ++j) edges.push_back(edge(simplices[at + i], simplices[at + j]));
      }
    }
  };
  add(mesh.cells, mesh.dim + 1);
  add(mesh.facets, mesh.dim);
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

class Splitter {
 public:
  explicit Splitter(const MeshData& coarse) : coarse_(coarse), edges_(edges_of(coarse)) {
    fine_.dim = coarse.dim;
    fine_.region_names = coarse.region_names;
    fine_.curve_names = coarse.curve_names;
    fine_.stray_curves = coarse.stray_curves;
    fine_.source = coarse.source;
  }

  MeshData split() {
    add_nodes();
    const auto n_children = std::size_t{1} << coarse_.dim;
    const auto width = static_cast<std::size_t>(coarse_.dim) + 1;
    fine_.cells.reserve(n_children * coarse_.cells.size());
    fine_.cell_region.reserve(n_children * coarse_.cell_region.size());
    for (int c = 0; c < coarse_.n_cells(); ++c) {
      const int* nodes = &coarse_.cells[width * c];
      coarse_.dim == 2 ? split_triangle(nodes, fine_.cells) : split_tetrahedron(nodes);
      fine_.cell_region.insert(fine_.cell_region.end(), n_children, coarse_.cell_region[c]);
    }
    for (int f = 0; f < coarse_.n_facets(); ++f) {
      const int* nodes = &coarse_.facets[std::size_t(coarse_.dim) * f];
      if (coarse_.dim == 3) {
        split_triangle(nodes, fine_.facets);
      } else {
        const int m = middle(nodes[0], nodes[1]);
        fine_.facets.insert(fine_.facets.end(), {nodes[0], m, m, nodes[1]});
      }
      fine_.facet_curve.insert(fine_.facet_curve.end(), n_children / 2, coarse_.facet_curve[f]);
    }
    return std::move(fine_);
  }

 private:
  [[nodiscard]] int middle(int a, int b) const {
    const auto found = std::ranges::lower_bound(edges_, edge(a, b));
    return coarse_.n_nodes() + static_cast<int>(found - edges_.begin());
  }

  void add_nodes() {
    const int dim = coarse_.dim;
    const auto& x = coarse_.coordinates;
    fine_.coordinates = x;
    fine_.coordinates.reserve(x.size() + dim * edges_.size());
    for (const auto& [a, b] : edges_) {
      for (int k = 0; k < dim; ++k) {
        fine_.coordinates.push_back(0.5 * (x[dim * a + k] + x[dim * b + k]));
      }
    }
  }

  void split_triangle(const int* t, std::vector<int>& into) const {
    const int m[3] = {middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])};
    into.insert(into.end(),
                {t[0], m[0], m[2], m[0], t[1], m[1], m[2], m[1], t[2], m[0], m[1], m[2]});
  }

  [[nodiscard]] ReferencePlace place(int node) const {
    const double* x = &fine_.coordinates[std::size_t{3} * node];
    return {x[0], x[1], x[2]};
  }

  /// Of the octahedron between the midpoints of edges.
  struct Diagonal {
    int from, to;
    int ring[4];  ///< in the order that makes the four around it right-handed
  };

  [[nodiscard]] double worst_around(const Diagonal& d) const {
    double worst = 1;
    for (int i = 0; i < 4; ++i) {
      worst = std::min(
          worst, quality(Tetrahedron<ReferenceFrame>{place(d.from), place(d.to), place(d.ring[i]),
                                                     place(d.ring[(i + 1) % 4])}));
    }
    return worst;
  }

  // Four corners, and the octahedron between them in four around its best diagonal.
  void split_tetrahedron(const int* t) {
    const int m01 = middle(t[0], t[1]), m02 = middle(t[0], t[2]), m03 = middle(t[0], t[3]);
    const int m12 = middle(t[1], t[2]), m13 = middle(t[1], t[3]), m23 = middle(t[2], t[3]);
    fine_.cells.insert(fine_.cells.end(), {t[0], m01, m02, m03, m01, t[1], m12, m13,  //
                                           m02, m12, t[2], m23, m03, m13, m23, t[3]});
    const Diagonal diagonals[3] = {{m01, m23, {m02, m03, m13, m12}},
                                   {m02, m13, {m01, m12, m23, m03}},
                                   {m03, m12, {m01, m02, m23, m13}}};
    const auto& [p, q, ring] = *std::ranges::max_element(
        diagonals, {}, [&](const Diagonal& d) { return worst_around(d); });
    for (int i = 0; i < 4; ++i) {
      fine_.cells.insert(fine_.cells.end(), {p, q, ring[i], ring[(i + 1) % 4]});
    }
  }

  const MeshData& coarse_;
  std::vector<Edge> edges_;
  MeshData fine_;
};

}  // namespace

MeshData refine(const MeshData& coarse, int times) {
  if (times < 0) {
    throw InputError(coarse.source + ": refine = " + std::to_string(times) +
                     "; allowed: 0 or more");
  }
  int most = 0;
  const std::size_t n_children = std::size_t{1} << coarse.dim;
  const std::size_t most_entries = std::numeric_limits<int>::max() / n_children;
  for (auto n = coarse.cells.size(); n <= most_entries; n *= n_children) ++most;
  if (times > most) {
    throw InputError(coarse.source + ": refine = " + std::to_string(times) + " makes too many " +
                     (coarse.dim == 2 ? "triangles" : "tetrahedra") + "; allowed here: up to " +
                     std::to_string(most));
  }
  MeshData mesh = coarse;
  for (int i = 0; i < times; ++i) mesh = Splitter(mesh).split();
  return mesh;
}

}  // namespace stylet
