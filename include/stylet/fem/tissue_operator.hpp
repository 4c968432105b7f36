// M, C and K of the tissue, kept up to date with the reference mesh.
//
// The rank that owns a node computes its rows from all cells around it, in global cell order, so K
// has the same bits on any number of ranks, and a row that was rebuilt after an edit has the same
// bits as in a fresh operator. C = mass_factor M + stiffness_factor K is never stored. Constraints
// never touch these matrices.
//
// The sparsity pattern holds, besides the mesh's own couplings, those that edge flips near the
// needle's path may need; where they do not suffice the pattern is made anew (counted).
#pragma once

#include "stylet/fem/element.hpp"
#include "stylet/fem/parameters.hpp"
#include "stylet/fem/split_stiffness.hpp"
#include "stylet/fem/volume_patch.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/region_map.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/owned.hpp"

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>
#include <vector>

namespace stylet {

/// The volumetric part of a cell's stress and energy.
struct VolumetricState {
  double pressure = 0;        ///< lambda tr(eps), averaged as the formulation does (Pa)
  double energy_density = 0;  ///< J/m^3
};

/// Rows of  mass M + stiffness K.
struct Combination {
  double mass = 0;
  double stiffness = 0;
};

/// What is kept of K: a matrix of PETSc, which also holds the couplings that flips may bring; or plain
/// rows, for who multiplies cell by cell (CellOperator) and only looks at rows near an edit.
enum class Stiffness { matrix, rows };

class TissueOperator {
 public:
  /// Collective. first_node: rank r owns nodes first_node[r] .. first_node[r+1]-1, dof = dim node +
  /// component. needs_flips(node): true where edges may be flipped later. keeps_regions: regions that
  /// are alike now may differ later (`change`). Throws InputError if a region of the mesh has no
  /// material or a material no region.
  TissueOperator(MPI_Comm comm,
                 const Mesh& mesh,
                 std::vector<int> first_node,
                 const TissueParameters& parameters,
                 std::function<bool(int)> needs_flips = {},
                 Stiffness kept = Stiffness::matrix,
                 bool keeps_regions = false);

  /// Collective. Rebuilds the rows of all nodes of the touched cells, in K, M and every tangent made
  /// by make_tangent. Returns true if the pattern had to be made anew.
  bool update(const Mesh& mesh, std::span<const int> touched_cells);
  /// Collective. Goes on from another state of the mesh: all matrices anew, with the pattern of the mesh as
  /// it is; no tangent. rewritten: cells that edits have touched until then.
  void renew(const Mesh& mesh,
             const TissueParameters& parameters,
             std::span<const int> rewritten,
             std::function<bool(int)> needs_flips);
  /// Cells that edits have touched, where their regions may differ.
  [[nodiscard]] const std::set<int>& rewritten() const { return rewritten_; }

  /// Collective. Edges may be flipped elsewhere from now on: makes the pattern anew.
  void expect_flips(const Mesh& mesh, std::function<bool(int)> needs_flips);
  /// Collective. Other moduli and damping of the same regions: makes K anew, and the tangent with the
  /// combination that it has. Throws InputError for moduli that are none; nothing has changed then.
  void change(const Mesh& mesh, const TissueParameters& parameters);

  /// Nodes whose rows `update` rebuilds for these cells; ascending, of all ranks.
  [[nodiscard]] std::vector<int> rows_of(const Mesh& mesh, std::span<const int> cells) const;
  /// Nodes that rows of these nodes couple to; ascending.
  [[nodiscard]] std::vector<int> coupled(const Mesh& mesh, std::span<const int> nodes) const;

  [[nodiscard]] MPI_Comm comm() const { return comm_; }
  /// Null if K is kept as rows.
  [[nodiscard]] Mat stiffness() const { return stiffness_.get(); }
  /// Calls each(column, value) along an owned row of K, by ascending columns; zeros may be left out.
  template <class Each>
  void along_row(int row, Each&& each) const;
  /// y = K x. Collective; with plain rows for now and then only.
  void apply_stiffness(Vec x, Vec y) const;
  /// Consistent mass, or null if lumped.
  [[nodiscard]] Mat mass() const { return mass_.get(); }
  /// Row-sum mass, one value a dof (kg); null if consistent.
  [[nodiscard]] Vec lumped_mass() const { return lumped_.get(); }
  /// y = M x. Collective.
  void apply_mass(Vec x, Vec y) const;
  [[nodiscard]] const std::optional<RayleighDamping>& damping() const {
    return parameters_.damping;
  }
  /// shift_a M + shift_v C + K as a combination of M and K (PETSc's I2 tangent).
  [[nodiscard]] Combination tangent(double shift_v, double shift_a) const;

  /// Collective. Makes the matrix of a combination; from now on `update` keeps it up to date too.
  void make_tangent(Combination combination);
  /// The matrix that make_tangent made; a new object where the pattern was made anew.
  [[nodiscard]] Mat tangent_matrix() const { return tangent_.get(); }

  /// Collective. The saddle form of a combination (split_stiffness.hpp), or null where K has no such form.
  [[nodiscard]] Mat saddle(Combination combination);

  /// A vector of dofs with this layout. Collective.
  [[nodiscard]] OwnedVec make_vector() const;
  /// Dofs a node: 2 in the plane, 3 in space.
  [[nodiscard]] int dim() const { return dim_; }
  [[nodiscard]] int first_dof() const { return dim_ * begin_; }
  [[nodiscard]] int end_dof() const { return dim_ * end_; }
  [[nodiscard]] int n_dofs() const { return dim_ * first_node_.back(); }
  [[nodiscard]] const std::vector<int>& first_node() const { return first_node_; }
  [[nodiscard]] bool owns(int node) const { return node >= begin_ && node < end_; }

  [[nodiscard]] const TissueParameters& parameters() const { return parameters_; }
  /// Moduli (Pa) and density (kg/m^3) of a cell; a mixture where an edited cell covers regions.
  [[nodiscard]] Moduli moduli(int cell) const;
  [[nodiscard]] double density(int cell) const;
  /// u: displacements of all dofs (m); known: of the same u, from cell to cell.
  [[nodiscard]] VolumetricState volumetric(const Mesh& mesh,
                                           int cell,
                                           std::span<const double> u,
                                           PatchPressures& known) const;

 private:
  struct CellMaterial {
    Moduli moduli;
    double density;
  };
  template <int Dim>
  using PatchCache = std::unordered_map<int, std::vector<VolumePatch<Dim>>>;
  void take_materials(const Mesh& mesh);
  void make_pattern(const Mesh& mesh);
  void fill_all(const Mesh& mesh);
  void fill_rows(const Mesh& mesh, std::span<const int> owned_nodes);
  struct NodeRows {
    std::vector<int> columns;    ///< nodes, ascending
    std::vector<double> values;  ///< rows of K, one a component
  };
  struct Masses {
    std::vector<double> consistent;  ///< of mass_columns
    double lumped = 0;
  };
  template <int Dim>
  void compute(const Mesh& mesh,
               int node,
               std::span<const int> mass_columns,
               NodeRows& rows,
               Masses& masses) const;
  void fill(const Mesh& mesh, std::span<const int> owned_nodes);
  template <int Dim>
  void fill_matrices(const Mesh& mesh, std::span<const int> owned_nodes);
  [[nodiscard]] CellMaterial material(int cell) const;
  void remix(const Mesh& mesh, std::span<const int> cells);
  [[nodiscard]] bool averaged() const {
    return parameters_.formulation == Formulation::p1_averaged;
  }
  template <int Dim>
  [[nodiscard]] std::vector<VolumePatch<Dim>> patches(const Mesh& mesh, int node) const;
  template <int Dim>
  [[nodiscard]] const std::vector<VolumePatch<Dim>>& patches(const Mesh& mesh,
                                                             int node,
                                                             PatchCache<Dim>& cache) const;
  template <int Dim>
  void add_shared_volume(const Mesh& mesh,
                         int node,
                         std::span<const int> columns,
                         PatchCache<Dim>& cache,
                         std::vector<double>& rows) const;
  template <int Dim>
  [[nodiscard]] VolumetricState volumetric_in(const Mesh& mesh,
                                              int cell,
                                              std::span<const double> u,
                                              PatchPressures& known) const;

  MPI_Comm comm_;
  int dim_;
  std::vector<int> first_node_;
  int begin_ = 0;
  int end_ = 0;
  TissueParameters parameters_;
  std::function<bool(int)> needs_flips_;
  std::vector<CellMaterial> by_region_;
  std::optional<RegionMap> region_map_;
  std::vector<int> cell_region_;
  std::map<int, CellMaterial> mixed_;
  bool uniform_ = true;  ///< all regions are alike
  std::set<int> rewritten_;
  /// Of owned nodes: column nodes of K and of M, ascending. The same unless the formulation averages.
  std::vector<std::vector<int>> stiffness_columns_;
  std::vector<std::vector<int>> mass_columns_;
  Stiffness kept_;
  std::vector<NodeRows> rows_;               ///< of owned nodes
  std::optional<std::uint64_t> columns_of_;  ///< version of the mesh's edges
  OwnedMat stiffness_;
  std::optional<SplitStiffness> split_;  ///< in space, with averaged dilatation
  OwnedNullSpace rigid_;
  OwnedMat mass_;
  OwnedVec lumped_;
  OwnedMat tangent_;
  Combination tangent_combination_;
};

template <class Each>
void TissueOperator::along_row(int row, Each&& each) const {
  if (kept_ == Stiffness::rows) {
    const NodeRows& of_node = rows_[static_cast<std::size_t>(row / 2 - begin_)];
    const double* value = of_node.values.data() + (row % 2) * 2 * of_node.columns.size();
    for (const int node : of_node.columns) {
      each(2 * node, *value++);
      each(2 * node + 1, *value++);
    }
    return;
  }
  stylet::along_row(stiffness_.get(), row, each);
}

}  // namespace stylet
