#include "stylet/mesh/refine.hpp"

#include "stylet/base/errors.hpp"

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
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const int* t = &mesh.cells[std::size_t{3} * c];
    for (int k = 0; k < 3; ++k) edges.push_back(edge(t[k], t[(k + 1) % 3]));
  }
  for (int f = 0; f < mesh.n_facets(); ++f) {
    edges.push_back(edge(mesh.facets[std::size_t{2} * f], mesh.facets[std::size_t{2} * f + 1]));
  }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

MeshData refine_once(const MeshData& coarse) {
  const std::vector<Edge> edges = edges_of(coarse);
  const auto middle = [&](int a, int b) {
    const auto found = std::ranges::lower_bound(edges, edge(a, b));
    return coarse.n_nodes() + static_cast<int>(found - edges.begin());
  };
  MeshData fine;
  fine.region_names = coarse.region_names;
  fine.curve_names = coarse.curve_names;
  fine.stray_curves = coarse.stray_curves;
  fine.source = coarse.source;
  fine.coordinates = coarse.coordinates;
  fine.coordinates.reserve(coarse.coordinates.size() + 2 * edges.size());
  for (const auto& [a, b] : edges) {
    for (int k = 0; k < 2; ++k) {
      fine.coordinates.push_back(0.5 *
                                 (coarse.coordinates[2 * a + k] + coarse.coordinates[2 * b + k]));
    }
  }
  fine.cells.reserve(4 * coarse.cells.size());
  fine.cell_region.reserve(4 * coarse.cell_region.size());
  for (int c = 0; c < coarse.n_cells(); ++c) {
    const int* t = &coarse.cells[std::size_t{3} * c];
    const int m[3] = {middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])};
    const int children[12] = {t[0], m[0], m[2], m[0], t[1], m[1],
                              m[2], m[1], t[2], m[0], m[1], m[2]};
    fine.cells.insert(fine.cells.end(), std::begin(children), std::end(children));
    fine.cell_region.insert(fine.cell_region.end(), 4, coarse.cell_region[c]);
  }
  for (std::size_t f = 0; f < coarse.facet_curve.size(); ++f) {
    const int a = coarse.facets[2 * f];
    const int b = coarse.facets[2 * f + 1];
    const int m = middle(a, b);
    fine.facets.insert(fine.facets.end(), {a, m, m, b});
    fine.facet_curve.insert(fine.facet_curve.end(), 2, coarse.facet_curve[f]);
  }
  return fine;
}

}  // namespace

MeshData refine(const MeshData& coarse, int times) {
  if (coarse.dim != 2) {
    throw InputError(coarse.source + ": refine: only triangles can be split, not tetrahedra");
  }
  if (times < 0) {
    throw InputError(coarse.source + ": refine = " + std::to_string(times) +
                     "; allowed: 0 or more");
  }
  int most = 0;
  for (auto n = coarse.cells.size(); n <= std::numeric_limits<int>::max() / 4; n *= 4) ++most;
  if (times > most) {
    throw InputError(coarse.source + ": refine = " + std::to_string(times) +
                     " makes too many triangles; allowed here: up to " + std::to_string(most));
  }
  MeshData mesh = coarse;
  for (int i = 0; i < times; ++i) mesh = refine_once(mesh);
  return mesh;
}

}  // namespace stylet
