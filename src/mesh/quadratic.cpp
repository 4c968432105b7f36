#include "stylet/mesh/quadratic.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/index.hpp"
#include "stylet/base/sorted.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

namespace stylet {

namespace {

using Edge = std::pair<int, int>;

/// Calls each(cell or facet, edge) for the edges of simplices of `width` corners.
template <class Each>
void along_edges(const std::vector<int>& corners, std::size_t width, Each&& each) {
  for (std::size_t i = 0; width * i < corners.size(); ++i) {
    for (const auto& [a, b] : tetrahedron_edges) {
      if (a >= width || b >= width) continue;
      each(i, Edge(std::minmax(corners[width * i + a], corners[width * i + b])));
    }
  }
}

}  // namespace

void add_mid_edge_nodes(MeshData& mesh) {
  std::vector<Edge> edges;
  along_edges(mesh.cells, 4, [&](std::size_t, Edge edge) { edges.push_back(edge); });
  sort_unique(edges);
  const auto n_corners = static_cast<std::size_t>(mesh.n_nodes());
  if (3 * (n_corners + edges.size()) > std::size_t{std::numeric_limits<int>::max()}) {
    throw InputError(mesh.source + ": too many edges for 32-bit numbers");
  }
  for (const auto& [a, b] : edges) {
    for (std::size_t k = 0; k < 3; ++k) {
      mesh.coordinates.push_back(
          0.5 * (mesh.coordinates[3 * at(a) + k] + mesh.coordinates[3 * at(b) + k]));
    }
  }
  const auto join = [&](const std::vector<int>& corners, std::size_t width, std::vector<int>& to) {
    const std::size_t wide = width * (width + 1) / 2;
    to.assign(corners.size() / width * wide, 0);
    std::vector<std::size_t> next(corners.size() / width, width);
    for (std::size_t i = 0; i < next.size(); ++i) {
      std::copy_n(&corners[width * i], width, &to[wide * i]);
    }
    along_edges(corners, width, [&](std::size_t i, Edge edge) {
      const auto found = std::ranges::lower_bound(edges, edge) - edges.begin();
      to[wide * i + next[i]++] = static_cast<int>(n_corners) + static_cast<int>(found);
    });
  };
  join(mesh.cells, 4, mesh.quadratic_cells);
  join(mesh.facets, 3, mesh.quadratic_facets);
}

}  // namespace stylet
