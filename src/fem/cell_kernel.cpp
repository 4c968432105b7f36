#include "stylet/fem/cell_kernel.hpp"

#include "stylet/base/index.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/fem/simplex.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stylet {

namespace {

// Cells with a node that is at most `rings` edges away from an owned one; ascending.
std::vector<int> cells_within(const Mesh& mesh, const TissueOperator& tissue, int rings) {
  std::vector<char> near(at(mesh.n_nodes()), 0);
  std::fill(near.begin() + tissue.first_dof() / 2, near.begin() + tissue.end_dof() / 2, 1);
  std::vector<int> cells;
  for (int ring = 0;; ++ring) {
    cells.clear();
    for (int c = 0; c < mesh.n_cells(); ++c) {
      if (std::ranges::any_of(mesh.cell(c), [&](int n) { return near[at(n)] != 0; })) {
        cells.push_back(c);
      }
    }
    if (ring == rings) return cells;
    for (const int c : cells) {
      for (const int node : mesh.cell(c)) near[at(node)] = 1;
    }
  }
}

std::vector<VolumePatch<2>> patches_of(const Mesh& mesh, const TissueOperator& tissue, int node) {
  return volume_patches<2>(mesh, node, [&](int cell) { return tissue.moduli(cell).lambda; });
}

}  // namespace

CellKernel::CellKernel(const Mesh& mesh, const TissueOperator& tissue)
    : averaged_(tissue.parameters().formulation == Formulation::p1_averaged),
      consistent_(tissue.parameters().mass == MassKind::consistent) {
  std::vector<int> order = cells_within(mesh, tissue, averaged_ ? 2 : 1);
  std::vector<int> ghosts;
  for (const int c : order) {
    for (const int node : mesh.cell(c)) {
      if (!tissue.owns(node)) ghosts.push_back(node);
    }
  }
  sort_unique(ghosts);
  nodes_ = {tissue.first_dof() / 2, tissue.end_dof() / 2, std::move(ghosts)};
  const std::size_t n_nodes = nodes_.n_all();
  if (averaged_) {
    std::vector<int> all(nodes_.n_owned());
    std::iota(all.begin(), all.end(), tissue.first_dof() / 2);
    all.insert(all.end(), nodes_.ghosts().begin(), nodes_.ghosts().end());
    for (const int node : all) {
      const auto patches = patches_of(mesh, tissue, node);
      first_region_.push_back(patches.front().region);
      for (std::size_t i = 1; i < patches.size(); ++i) {
        further_node_.push_back(nodes_.of(node));
        further_region_.push_back(patches[i].region);
      }
    }
    patch_stiffness_.resize(n_nodes + further_node_.size());
    for (const int node : all) weigh(mesh, tissue, node);
  }
  std::ranges::stable_sort(order, {}, [&](int c) { return lowest(mesh.cell(c)); });
  const std::size_t n_blocks = (n_nodes + block - 1) / block;
  slot_.assign(at(mesh.n_cells()), nowhere);
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
  if (consistent_) masses_.resize(lanes * groups_.size());
  return groups_.size() - 1;
}

void CellKernel::put(std::size_t slot, const Mesh& mesh, const TissueOperator& tissue, int cell) {
  const std::size_t group = slot / lanes;
  const std::size_t lane = slot % lanes;
  const auto nodes = mesh.cell(cell);
  const auto element = simplex<2>(mesh, cell);
  const double volume = tissue.parameters().thickness * element.measure;
  const Moduli m = tissue.moduli(cell);
  const double scale = std::sqrt(m.mu * volume);
  Group& g = groups_[group];
  std::size_t& reach = reach_[group_block_[group]];
  for (std::size_t a = 0; a < 3; ++a) {
    const int local = nodes_.of(nodes[a]);
    g.dof[a][lane] = 2 * local;
    reach = std::max(reach, at(local) + 1);
    if (averaged_) patches_[group].patch[a][lane] = patch_of(local, mesh.region(cell));
  }
  for (std::size_t a = 0; a < 2; ++a) {
    for (std::size_t i = 0; i < 2; ++i) {
      g.gradient[2 * a + i][lane] = scale * element.gradient[a][i];
    }
  }
  if (consistent_) masses_[slot] = tissue.density(cell) * volume / 12;
  g.volume[lane] = averaged_ ? std::sqrt(volume / m.mu) / 3 : m.lambda / m.mu;
}

std::size_t CellKernel::lowest(std::span<const int> nodes) const {
  int least = nodes_.of(nodes[0]);
  for (const int node : nodes) least = std::min(least, nodes_.of(node));
  return at(least);
}

bool CellKernel::knows(std::span<const int> nodes) const {
  return std::ranges::all_of(nodes, [&](int node) { return nodes_.of(node) >= 0; });
}

// Whether the forces on owned nodes depend on it.
bool CellKernel::needs(const Mesh& mesh, int cell) const {
  const auto owned = [&](int node) { return nodes_.owns(node); };
  return std::ranges::any_of(mesh.cell(cell), [&](int node) {
    return owned(node) || (averaged_ && std::ranges::any_of(mesh.neighbours(node), owned));
  });
}

// -1 if there is none.
int CellKernel::patch_of(int local, int region) const {
  if (first_region_[at(local)] == region) return local;
  const auto range = std::ranges::equal_range(further_node_, local);
  for (auto n = range.begin(); n != range.end(); ++n) {
    const auto i = static_cast<std::size_t>(n - further_node_.begin());
    if (further_region_[i] == region) return static_cast<int>(nodes_.n_all() + i);
  }
  return -1;
}

void CellKernel::weigh(const Mesh& mesh, const TissueOperator& tissue, int node) {
  for (const VolumePatch<2>& patch : patches_of(mesh, tissue, node)) {
    patch_stiffness_[at(patch_of(nodes_.of(node), patch.region))] =
        1 / (tissue.parameters().thickness * patch.compliance);
  }
}

bool CellKernel::update(const Mesh& mesh,
                        const TissueOperator& tissue,
                        std::span<const int> cells) {
  for (const int cell : cells) {
    const auto nodes = mesh.cell(cell);
    std::size_t& slot = slot_[at(cell)];
    const bool known = knows(nodes);
    if (slot == nowhere || !known) {
      if (needs(mesh, cell)) return false;
      if (slot == nowhere) continue;
    }
    const std::size_t own = known ? block_of(nodes) : 0;
    if (!known || own < group_block_[slot / lanes]) {  // after a flip
      for (auto& values : groups_[slot / lanes].gradient) values[slot % lanes] = 0;
      if (consistent_) masses_[slot] = 0;
      slot = nowhere;
      if (!known) continue;
      slot = lanes * add_group(own);
      next_moved_.push_back(moved_[own]);
      moved_[own] = static_cast<int>(slot / lanes);
    }
    put(slot, mesh, tissue, cell);
  }
  if (!averaged_) return true;
  for (const int cell : cells) {
    for (const int node : mesh.cell(cell)) {
      if (nodes_.of(node) >= 0) weigh(mesh, tissue, node);
    }
  }
  return true;
}

}  // namespace stylet
