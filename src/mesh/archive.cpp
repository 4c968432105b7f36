// What of a mesh and of the points in it the needle changes.
#include "stylet/geometry/archive.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/mesh/embedded_point.hpp"
#include "stylet/mesh/mesh.hpp"

namespace stylet {

// Boundaries, locks, regions and facets stay as they were made.
void Mesh::archive(Archive& archive) {
  const auto& nodes = archive.order().nodes;
  const auto& cells = archive.order().cells;
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  // From the numbers of the run to the source's, or back.
  std::vector<double> coordinates(data_.coordinates.size());
  std::vector<int> corners(data_.cells.size());
  const std::size_t dim = at(this->dim());
  const auto each = [&](auto&& point, auto&& cell) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      for (std::size_t k = 0; k < dim; ++k) point(dim * i + k, dim * at(nodes[i]) + k);
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
      for (std::size_t k = 0; k <= dim; ++k) {
        cell((dim + 1) * i + k, (dim + 1) * at(cells[i]) + k);
      }
    }
  };
  if (!archive.loads()) {
    each([&](std::size_t from, std::size_t to) { coordinates[to] = data_.coordinates[from]; },
         [&](std::size_t from, std::size_t to) { corners[to] = nodes[at(data_.cells[from])]; });
  }
  archive.array("coordinates", coordinates, dim);
  archive.array("cells", corners, dim + 1);
  archive("version", version_);
  archive("connectivity_version", connectivity_version_);
  if (!archive.loads()) return;
  for (const int node : corners) {
    if (node < 0 || node >= n_nodes()) throw InputError("a cell has a node that is none");
  }
  each([&](std::size_t from, std::size_t to) { data_.coordinates[to] = coordinates[from]; },
       [&](std::size_t from, std::size_t to) { data_.cells[to] = nodes[at(corners[from])]; });
  for (auto& around : around_) around.clear();
  for (int c = 0; c < n_cells(); ++c) {
    for (const int node : this->nodes(c)) around_[at(node)].push_back(c);
  }
}

void archive(Archive& archive, EmbeddedPoint& point) {
  auto& [x, cell, weights] = point;
  archive("x", x);
  archive.cell("cell", cell);
  for (double& weight : weights) archive("weights", weight);
}

}  // namespace stylet
