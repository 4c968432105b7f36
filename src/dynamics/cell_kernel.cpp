#include "stylet/dynamics/cell_kernel.hpp"

#include "stylet/fem/element.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stylet {

namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

int lowest(std::span<const int> nodes) {
  return *std::ranges::min_element(nodes);
}

std::size_t block_of(std::span<const int> nodes) {
  return at(lowest(nodes)) / CellKernel::block;
}

}  // namespace

CellKernel::CellKernel(const Mesh& mesh, const TissueOperator& tissue)
    : averaged_(tissue.parameters().formulation == Formulation::p1_averaged) {
  const auto n_nodes = at(mesh.n_nodes());
  const std::size_t n_blocks = (n_nodes + block - 1) / block;
  if (averaged_) {
    first_region_.assign(n_nodes, -1);
    for (int node = 0; node < mesh.n_nodes(); ++node) {
      for (const int c : mesh.cells_around(node)) {
        int& first = first_region_[at(node)];
        if (first < 0) first = mesh.region(c);
        if (mesh.region(c) == first || patch_of(mesh, node, mesh.region(c)) >= 0) continue;
        further_node_.push_back(node);
        further_region_.push_back(mesh.region(c));
      }
    }
    patch_stiffness_.resize(n_nodes + further_node_.size());
    for (int node = 0; node < mesh.n_nodes(); ++node) weigh(mesh, tissue, node);
  }
  std::vector<int> order(at(mesh.n_cells()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int c) { return lowest(mesh.cell(c)); });
  slot_.resize(order.size());
  reach_.resize(n_blocks);
  moved_.assign(n_blocks, -1);
  std::size_t next = 0;
  for (std::size_t k = 0; k < n_blocks; ++k) {
    first_group_.push_back(groups_.size());
    reach_[k] = std::min(n_nodes, (k + 1) * block);
    std::size_t end = next;
    while (end < order.size() && block_of(mesh.cell(order[end])) == k) ++end;
    // Each lane takes consecutive triangles, so that those of a group are far apart and their sums do
    // not wait for each other.
    const std::size_t n_groups = (end - next + lanes - 1) / lanes;
    for (std::size_t g = 0; g < n_groups; ++g) add_group(k);
    for (std::size_t i = 0; next < end; ++i, ++next) {
      const std::size_t slot = lanes * (first_group_[k] + i % n_groups) + i / n_groups;
      slot_[at(order[next])] = slot;
      put(slot, mesh, tissue, order[next]);
    }
  }
  first_group_.push_back(groups_.size());
}

// All lanes idle: without gradients, at a node of the block.
std::size_t CellKernel::add_group(std::size_t of) {
  Group idle{};
  Patches patches{};
  for (std::size_t a = 0; a < 3; ++a) {
    std::ranges::fill(idle.dof[a], static_cast<int>(2 * of * block));
    std::ranges::fill(patches.patch[a], static_cast<int>(of * block));
  }
  groups_.push_back(idle);
  group_block_.push_back(of);
  if (averaged_) patches_.push_back(patches);
  return groups_.size() - 1;
}

void CellKernel::put(std::size_t slot, const Mesh& mesh, const TissueOperator& tissue, int cell) {
  const std::size_t group = slot / lanes;
  const std::size_t lane = slot % lanes;
  const auto nodes = mesh.cell(cell);
  const LinearSimplex<2> element(
      {mesh.coordinates(nodes[0]), mesh.coordinates(nodes[1]), mesh.coordinates(nodes[2])});
  const double volume = tissue.parameters().thickness * element.measure;
  const Moduli m = tissue.moduli(cell);
  const double scale = std::sqrt(m.mu * volume);
  Group& g = groups_[group];
  std::size_t& reach = reach_[group_block_[group]];
  for (std::size_t a = 0; a < 3; ++a) {
    g.dof[a][lane] = 2 * nodes[a];
    reach = std::max(reach, at(nodes[a]) + 1);
  }
  for (std::size_t a = 0; a < 2; ++a) {
    for (std::size_t i = 0; i < 2; ++i) {
      g.gradient[2 * a + i][lane] = scale * element.gradient[a][i];
    }
  }
  g.volume[lane] = averaged_ ? std::sqrt(volume / m.mu) / 3 : m.lambda / m.mu;
  if (!averaged_) return;
  for (std::size_t a = 0; a < 3; ++a) {
    patches_[group].patch[a][lane] = patch_of(mesh, nodes[a], mesh.region(cell));
  }
}

// -1 if there is none.
int CellKernel::patch_of(const Mesh& mesh, int node, int region) const {
  if (first_region_[at(node)] == region) return node;
  const auto range = std::ranges::equal_range(further_node_, node);
  for (auto n = range.begin(); n != range.end(); ++n) {
    const auto i = static_cast<std::size_t>(n - further_node_.begin());
    if (further_region_[i] == region) return mesh.n_nodes() + static_cast<int>(i);
  }
  return -1;
}

// W_n of all patches of a node.
void CellKernel::weigh(const Mesh& mesh, const TissueOperator& tissue, int node) {
  const auto cells = mesh.cells_around(node);
  for (const int c : cells) {
    const int region = mesh.region(c);
    double compliance = 0;
    for (const int other : cells) {
      if (mesh.region(other) != region) continue;
      compliance += mesh.cell_measure(other) / (3 * tissue.moduli(other).lambda);
    }
    patch_stiffness_[at(patch_of(mesh, node, region))] =
        1 / (tissue.parameters().thickness * compliance);
  }
}

void CellKernel::update(const Mesh& mesh,
                        const TissueOperator& tissue,
                        std::span<const int> cells) {
  for (const int cell : cells) {
    const auto nodes = mesh.cell(cell);
    std::size_t& slot = slot_[at(cell)];
    const std::size_t own = block_of(nodes);
    if (own < group_block_[slot / lanes]) {  // after a flip
      for (auto& values : groups_[slot / lanes].gradient) values[slot % lanes] = 0;
      slot = lanes * add_group(own);
      next_moved_.push_back(moved_[own]);
      moved_[own] = static_cast<int>(slot / lanes);
    }
    put(slot, mesh, tissue, cell);
  }
  if (!averaged_) return;
  for (const int cell : cells) {
    for (const int node : mesh.cell(cell)) weigh(mesh, tissue, node);
  }
}

}  // namespace stylet
