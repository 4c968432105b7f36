// The triangles as products with K need them: four at a time, with stored gradients, in the
// order of their lowest node. A triangle's data are two fifths of the bytes of its share of K's blocks,
// and one where the dilatation is averaged.
#pragma once

#include "stylet/fem/tissue_operator.hpp"
#include "stylet/mesh/mesh.hpp"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace stylet {

/// Local numbers of nodes: owned ones, then the ghosts that this rank's triangles also have.
class LocalNodes {
 public:
  LocalNodes() = default;
  /// Owned: first .. end - 1. ghosts: ascending.
  LocalNodes(int first, int end, std::vector<int> ghosts)
      : first_(first), n_owned_(end - first), ghosts_(std::move(ghosts)) {}
  [[nodiscard]] std::size_t n_owned() const { return static_cast<std::size_t>(n_owned_); }
  [[nodiscard]] std::size_t n_all() const { return n_owned() + ghosts_.size(); }
  [[nodiscard]] const std::vector<int>& ghosts() const { return ghosts_; }
  [[nodiscard]] bool owns(int node) const { return node >= first_ && node < first_ + n_owned_; }
  /// -1 if it is neither.
  [[nodiscard]] int of(int node) const {
    if (owns(node)) return node - first_;
    const auto found = std::ranges::lower_bound(ghosts_, node);
    if (found == ghosts_.end() || *found != node) return -1;
    return n_owned_ + static_cast<int>(found - ghosts_.begin());
  }

 private:
  int first_ = 0;
  int n_owned_ = 0;
  std::vector<int> ghosts_;
};

/// All that push owned nodes, and one ring more, where flips may bring others in.
class CellKernel {
 public:
  static constexpr std::size_t lanes = 4;
  static constexpr std::size_t block = 128;  ///< nodes

  /// Corner a's gradient g_a, times s = sqrt(mu |T|): of corners 0 and 1 as (x, y, x, y); the third's
  /// is minus their sum. volume: lambda / mu, or sqrt(|T| / mu) / 3 if the dilatation is averaged.
  struct Group {
    int dof[3][lanes];  ///< the first of each corner
    double gradient[4][lanes];
    double volume[lanes];
  };
  /// Shares of the dilatation that the corners take part in (VolumePatch).
  struct Patches {
    int patch[3][lanes];
  };

  CellKernel() = default;
  CellKernel(const Mesh& mesh, const TissueOperator& tissue);
  /// Takes these cells anew; constant time for each. False if flips have brought in nodes that have no
  /// local number: then a new kernel is needed.
  [[nodiscard]] bool update(const Mesh& mesh,
                            const TissueOperator& tissue,
                            std::span<const int> cells);

  [[nodiscard]] const LocalNodes& nodes() const { return nodes_; }

  [[nodiscard]] bool averaged() const { return averaged_; }
  [[nodiscard]] std::size_t n_blocks() const { return reach_.size(); }
  /// Of local nodes: cells of block k have nodes from k * block to reach(k) - 1.
  [[nodiscard]] std::size_t reach(std::size_t k) const { return reach_[k]; }
  /// Calls each(group index) for the groups of a block.
  template <class Each>
  __attribute__((always_inline)) void groups_of(std::size_t k, Each&& each) const {
    for (std::size_t g = first_group_[k]; g < first_group_[k + 1]; ++g) each(g);
    for (int g = moved_[k]; g >= 0;
         g = next_moved_[static_cast<std::size_t>(g) - first_group_.back()]) {
      each(static_cast<std::size_t>(g));
    }
  }
  [[nodiscard]] const Group* groups() const { return groups_.data(); }
  [[nodiscard]] const Patches* patches() const { return patches_.data(); }
  /// A twelfth of each triangle's mass (kg), `lanes` a group, if it is consistent.
  [[nodiscard]] const double* masses() const { return masses_.data(); }
  /// Of each patch, thickness / W_n: patch n is node n's, or its first one's; the rest come last, with
  /// their nodes ascending.
  [[nodiscard]] const std::vector<double>& stiffnesses() const { return patch_stiffness_; }
  [[nodiscard]] const std::vector<int>& further_patches() const { return further_node_; }

 private:
  std::size_t add_group(std::size_t of);
  void put(std::size_t slot, const Mesh& mesh, const TissueOperator& tissue, int cell);
  [[nodiscard]] bool needs(const Mesh& mesh, int cell) const;
  [[nodiscard]] bool knows(std::span<const int> nodes) const;
  [[nodiscard]] std::size_t lowest(std::span<const int> nodes) const;
  [[nodiscard]] std::size_t block_of(std::span<const int> nodes) const {
    return lowest(nodes) / block;
  }
  [[nodiscard]] int patch_of(int local, int region) const;
  void weigh(const Mesh& mesh, const TissueOperator& tissue, int node);

  bool averaged_ = false;
  bool consistent_ = false;
  LocalNodes nodes_;
  std::vector<Group> groups_;     ///< in order, then those of cells that flips took out of it
  std::vector<Patches> patches_;  ///< of the groups, if averaged
  std::vector<double> masses_;
  std::vector<std::size_t> group_block_;
  std::vector<std::size_t> first_group_;  ///< of a block
  std::vector<std::size_t> reach_;
  std::vector<int> moved_;  ///< of a block, its last group out of order, or -1
  std::vector<int> next_moved_;
  static constexpr std::size_t nowhere = static_cast<std::size_t>(-1);
  std::vector<std::size_t> slot_;  ///< of a cell: lanes * group + lane
  std::vector<double> patch_stiffness_;
  std::vector<int> further_node_;
  std::vector<int> further_region_;
  std::vector<int> first_region_;  ///< of patches of local nodes
};

}  // namespace stylet
