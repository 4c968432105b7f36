#include "stylet/fem/volume_patch.hpp"

#include "stylet/base/sorted.hpp"
#include "stylet/fem/simplex.hpp"

#include <algorithm>

namespace stylet {

template <int Dim>
auto VolumePatch<Dim>::at(int node) const -> const Vector* {
  const auto found = std::ranges::lower_bound(nodes, node);
  if (found == nodes.end() || *found != node) return nullptr;
  return &divergence[static_cast<std::size_t>(found - nodes.begin())];
}

template <int Dim>
double VolumePatch<Dim>::pressure(std::span<const double> u) const {
  double volume = 0;
  for (std::size_t b = 0; b < nodes.size(); ++b) {
    const auto dof = Dim * static_cast<std::size_t>(nodes[b]);
    double share = 0;
    for (std::size_t k = 0; k < Dim; ++k) share += divergence[b][k] * u[dof + k];
    volume += share;
  }
  return volume / compliance;
}

template <int Dim>
std::vector<VolumePatch<Dim>> volume_patches(const Mesh& mesh,
                                             int node,
                                             const std::function<double(int)>& lambda) {
  constexpr std::size_t n_corners = Dim + 1;
  std::vector<VolumePatch<Dim>> patches;
  const auto cells = mesh.cells_around(node);
  for (const int c : cells) {
    const int region = mesh.region(c);
    auto patch = std::ranges::find(patches, region, &VolumePatch<Dim>::region);
    if (patch == patches.end()) {
      patch = patches.insert(patch, VolumePatch<Dim>{region, {}, {}, 0});
    }
    for (const int b : mesh.cell(c)) patch->nodes.push_back(b);
  }
  for (VolumePatch<Dim>& patch : patches) {
    sort_unique(patch.nodes);
    patch.divergence.assign(patch.nodes.size(), {});
    for (const int c : cells) {
      if (mesh.region(c) != patch.region) continue;
      const auto corners = mesh.cell(c);
      const auto element = simplex<Dim>(mesh, c);
      const double share = element.measure / n_corners;
      patch.compliance += share / lambda(c);
      for (std::size_t b = 0; b < n_corners; ++b) {
        const auto at = std::ranges::lower_bound(patch.nodes, corners[b]) - patch.nodes.begin();
        auto& of_node = patch.divergence[static_cast<std::size_t>(at)];
        for (std::size_t k = 0; k < Dim; ++k) of_node[k] += share * element.gradient[b][k];
      }
    }
  }
  return patches;
}

template struct VolumePatch<2>;
template struct VolumePatch<3>;
template std::vector<VolumePatch<2>> volume_patches<2>(const Mesh&,
                                                       int,
                                                       const std::function<double(int)>&);
template std::vector<VolumePatch<3>> volume_patches<3>(const Mesh&,
                                                       int,
                                                       const std::function<double(int)>&);

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
