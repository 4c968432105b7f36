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
  const auto each = [&](auto&& point, auto&& cell) {
    for (std::size_t i = 0; i < nodes.size(); ++i) point(2 * i, 2 * at(nodes[i]));
    for (std::size_t i = 0; i < cells.size(); ++i) cell(3 * i, 3 * at(cells[i]));
  };
  if (!archive.loads()) {
    each(
        [&](std::size_t from, std::size_t to) {
          for (std::size_t k = 0; k < 2; ++k) coordinates[to + k] = data_.coordinates[from + k];
        },
        [&](std::size_t from, std::size_t to) {
          for (std::size_t k = 0; k < 3; ++k) corners[to + k] = nodes[at(data_.cells[from + k])];
        });
  }
  archive.array("coordinates", coordinates, 2);
  archive.array("cells", corners, 3);
  archive("version", version_);
  archive("connectivity_version", connectivity_version_);
  if (!archive.loads()) return;
  for (const int node : corners) {
    if (node < 0 || node >= n_nodes()) throw InputError("a cell has a node that is none");
  }
  each(
      [&](std::size_t from, std::size_t to) {
        for (std::size_t k = 0; k < 2; ++k) data_.coordinates[to + k] = coordinates[from + k];
      },
      [&](std::size_t from, std::size_t to) {
        for (std::size_t k = 0; k < 3; ++k) data_.cells[to + k] = nodes[at(corners[from + k])];
      });
  for (auto& around : around_) around.clear();
  for (int c = 0; c < n_cells(); ++c) {
    for (const int node : cell(c)) around_[at(node)].push_back(c);
  }
}

void archive(Archive& archive, EmbeddedPoint& point) {
  auto& [x, cell, weights] = point;
  archive("x", x);
  archive.cell("cell", cell);
  for (double& weight : weights) archive("weights", weight);
}

}  // namespace stylet
