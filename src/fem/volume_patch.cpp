#include "stylet/fem/volume_patch.hpp"

#include "stylet/base/sorted.hpp"

#include <algorithm>

namespace stylet {

const LinearSimplex<2>::Vector* VolumePatch::at(int node) const {
  const auto found = std::ranges::lower_bound(nodes, node);
  if (found == nodes.end() || *found != node) return nullptr;
  return &divergence[static_cast<std::size_t>(found - nodes.begin())];
}

double VolumePatch::pressure(std::span<const double> u) const {
  double volume = 0;
  for (std::size_t b = 0; b < nodes.size(); ++b) {
    const auto dof = 2 * static_cast<std::size_t>(nodes[b]);
    volume += divergence[b][0] * u[dof] + divergence[b][1] * u[dof + 1];
  }
  return volume / compliance;
}

std::vector<VolumePatch> volume_patches(const Mesh& mesh,
                                        int node,
                                        const std::function<double(int)>& lambda) {
  std::vector<VolumePatch> patches;
  const auto cells = mesh.cells_around(node);
  for (const int c : cells) {
    const int region = mesh.region(c);
    auto patch = std::ranges::find(patches, region, &VolumePatch::region);
    if (patch == patches.end()) {
      patch = patches.insert(patch, VolumePatch{region, {}, {}, 0});
    }
    for (const int b : mesh.cell(c)) patch->nodes.push_back(b);
  }
  for (VolumePatch& patch : patches) {
    sort_unique(patch.nodes);
    patch.divergence.assign(patch.nodes.size(), {0, 0});
    for (const int c : cells) {
      if (mesh.region(c) != patch.region) continue;
      const auto corners = mesh.cell(c);
      const LinearSimplex<2> element({mesh.coordinates(corners[0]), mesh.coordinates(corners[1]),
                                      mesh.coordinates(corners[2])});
      const double share = element.measure / 3;
      patch.compliance += share / lambda(c);
      for (std::size_t b = 0; b < 3; ++b) {
        const auto at = std::ranges::lower_bound(patch.nodes, corners[b]) - patch.nodes.begin();
        auto& of_node = patch.divergence[static_cast<std::size_t>(at)];
        for (std::size_t k = 0; k < 2; ++k) of_node[k] += share * element.gradient[b][k];
      }
    }
  }
  return patches;
}

std::vector<int> nodes_within(const Mesh& mesh, int node, int rings) {
  std::vector<int> nodes{node};
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<int> wider;
    for (const int inner : nodes) {
      const auto around = mesh.neighbours(inner);
      wider.insert(wider.end(), around.begin(), around.end());
    }
    nodes = std::move(wider);
    sort_unique(nodes);
  }
  return nodes;
}

}  // namespace stylet
