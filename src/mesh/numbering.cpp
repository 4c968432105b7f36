#include "stylet/mesh/numbering.hpp"

#include "stylet/base/errors.hpp"

#include <metis.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>

namespace stylet {

namespace {

/// Neighbours of node i: adjacent[first[i]] .. adjacent[first[i + 1] - 1], in rising order.
struct Graph {
  std::vector<int> first;
  std::vector<int> adjacent;

  [[nodiscard]] int size() const { return static_cast<int>(first.size()) - 1; }
  [[nodiscard]] std::span<const int> neighbours(int i) const {
    return {adjacent.data() + first[i], adjacent.data() + first[i + 1]};
  }
};

Graph node_graph(const MeshData& mesh) {
  const int width = mesh.n_cell_nodes();
  const std::vector<int>& cell_nodes = mesh.cell_nodes();
  if (cell_nodes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max() / (width - 1))) {
    throw InputError(mesh.source + ": too many cells for 32-bit numbers");
  }
  std::vector<int> start(mesh.n_nodes() + 1, 0);
  for (int node : cell_nodes) start[node + 1] += width - 1;
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<int> all(start.back());
  std::vector<int> fill(start.begin(), start.end() - 1);
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const int* nodes = cell_nodes.data() + static_cast<std::ptrdiff_t>(width) * c;
    for (int i = 0; i < width; ++i) {
      for (int j = 0; j < width; ++j) {
        if (i != j) all[fill[nodes[i]]++] = nodes[j];
      }
    }
  }
  Graph graph;
  graph.first = {0};
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    const auto from = all.begin() + start[i];
    const auto to = all.begin() + start[i + 1];
    std::sort(from, to);
    graph.adjacent.insert(graph.adjacent.end(), from, std::unique(from, to));
    graph.first.push_back(static_cast<int>(graph.adjacent.size()));
  }
  return graph;
}

std::vector<int> owners(const Graph& graph, int n_ranks) {
  if (n_ranks == 1) return std::vector<int>(graph.size(), 0);
  std::vector<idx_t> first(graph.first.begin(), graph.first.end());
  std::vector<idx_t> adjacent(graph.adjacent.begin(), graph.adjacent.end());
  std::vector<idx_t> part(graph.size());
  idx_t n = graph.size();
  idx_t n_constraints = 1;
  idx_t n_parts = n_ranks;
  idx_t cut = 0;
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  options[METIS_OPTION_SEED] = 1;
  const int status =
      METIS_PartGraphKway(&n, &n_constraints, first.data(), adjacent.data(), nullptr, nullptr,
                          nullptr, &n_parts, nullptr, nullptr, options.data(), &cut, part.data());
  if (status != METIS_OK) {
    throw Error(status == METIS_ERROR_INPUT ? ExitCode::bad_input : ExitCode::other,
                "METIS cannot split " + std::to_string(graph.size()) + " nodes among " +
                    std::to_string(n_ranks) + " ranks (status " + std::to_string(status) +
                    (status == METIS_ERROR_MEMORY ? ": out of memory)" : ")"));
  }
  return {part.begin(), part.end()};
}

/// Cuthill-McKee within each rank: breadth first, neighbours of low degree first.
class CuthillMcKee {
 public:
  CuthillMcKee(const Graph& graph, const std::vector<int>& owner)
      : graph_(graph), owner_(owner), seen_(graph.size(), 0) {}

  /// The piece (connected within its rank) that contains `start`, in reverse order.
  std::vector<int> piece(int start) {
    // Two sweeps to the far end find a start at the rim of the piece; more gain little.
    for (int sweep = 0; sweep < 2; ++sweep) start = walk(start).back();
    std::vector<int> order = walk(start);
    std::ranges::reverse(order);
    return order;
  }

 private:
  std::vector<int> walk(int start) {
    ++stamp_;
    std::vector<int> order = {start};
    seen_[start] = stamp_;
    for (std::size_t at = 0; at < order.size(); ++at) {
      const int i = order[at];
      const std::size_t begin = order.size();
      for (int j : graph_.neighbours(i)) {
        if (owner_[j] != owner_[i] || seen_[j] == stamp_) continue;
        seen_[j] = stamp_;
        order.push_back(j);
      }
      std::stable_sort(order.begin() + static_cast<std::ptrdiff_t>(begin), order.end(),
                       [this](int a, int b) { return degree(a) < degree(b); });
    }
    return order;
  }
  [[nodiscard]] std::size_t degree(int i) const { return graph_.neighbours(i).size(); }

  const Graph& graph_;
  const std::vector<int>& owner_;
  std::vector<int> seen_;  ///< the last walk that met the node
  int stamp_ = 0;
};

/// Equal strips of the narrow order of the whole mesh, for meshes so small that METIS leaves a rank
/// empty.
std::vector<int> strips(const Graph& graph, int n_ranks) {
  const std::vector<int> one_rank(graph.size(), 0);
  CuthillMcKee cuthill_mckee(graph, one_rank);
  std::vector<int> owner(graph.size(), -1);
  std::int64_t position = 0;
  for (int i = 0; i < graph.size(); ++i) {
    if (owner[i] >= 0) continue;
    for (int j : cuthill_mckee.piece(i)) {
      owner[j] = static_cast<int>(position++ * n_ranks / graph.size());
    }
  }
  return owner;
}

std::vector<int> count_owned(const std::vector<int>& owner, int n_ranks) {
  std::vector<int> n(n_ranks, 0);
  for (int rank : owner) ++n[rank];
  return n;
}

}  // namespace

Numbering number_nodes(const MeshData& mesh, int n_ranks) {
  if (n_ranks < 1 || n_ranks > mesh.n_nodes()) {
    throw InputError(mesh.source + ": " + std::to_string(n_ranks) + " ranks; allowed: 1 to " +
                     std::to_string(mesh.n_nodes()) + ", the number of nodes");
  }
  const Graph graph = node_graph(mesh);
  std::vector<int> owner = owners(graph, n_ranks);
  if (std::ranges::count(count_owned(owner, n_ranks), 0) > 0) owner = strips(graph, n_ranks);
  Numbering result;
  result.first_node = {0};
  for (int n : count_owned(owner, n_ranks)) {
    result.first_node.push_back(result.first_node.back() + n);
  }

  constexpr int unnumbered = -1;
  result.new_of_old.assign(graph.size(), unnumbered);
  std::vector<int> next = result.first_node;
  CuthillMcKee cuthill_mckee(graph, owner);
  for (int i = 0; i < graph.size(); ++i) {
    if (result.new_of_old[i] != unnumbered) continue;
    for (int j : cuthill_mckee.piece(i)) result.new_of_old[j] = next[owner[j]]++;
  }
  return result;
}

MeshData renumber(const MeshData& mesh,
                  const Numbering& numbering,
                  std::vector<int>& old_cell_of_new) {
  const int n_corners = mesh.dim + 1;
  const int width = mesh.n_cell_nodes();
  const auto& number = numbering.new_of_old;
  MeshData result = mesh;
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    for (int k = 0; k < mesh.dim; ++k) {
      result.coordinates[mesh.dim * number[i] + k] = mesh.coordinates[mesh.dim * i + k];
    }
  }
  for (int& node : result.facets) node = number[node];
  for (int& node : result.quadratic_facets) node = number[node];

  std::vector<int> smallest(mesh.n_cells(), std::numeric_limits<int>::max());
  for (int c = 0; c < mesh.n_cells(); ++c) {
    for (int k = 0; k < n_corners; ++k) {
      smallest[c] = std::min(smallest[c], number[mesh.cells[n_corners * c + k]]);
    }
  }
  old_cell_of_new.resize(mesh.n_cells());
  std::iota(old_cell_of_new.begin(), old_cell_of_new.end(), 0);
  std::ranges::stable_sort(old_cell_of_new, {}, [&](int c) { return smallest[c]; });
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const int old = old_cell_of_new[c];
    result.cell_region[c] = mesh.cell_region[old];
    for (int k = 0; k < n_corners; ++k) {
      result.cells[n_corners * c + k] = number[mesh.cells[n_corners * old + k]];
    }
    if (!mesh.is_quadratic()) continue;
    for (int k = 0; k < width; ++k) {
      result.quadratic_cells[width * c + k] = number[mesh.quadratic_cells[width * old + k]];
    }
  }
  return result;
}

}  // namespace stylet
