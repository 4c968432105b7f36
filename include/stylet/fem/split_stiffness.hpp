// K of tetrahedra with averaged dilatation (volume_patch.hpp) in its parts:
//
//   K = K_s + D^T W^-1 D
//
// K_s: shear, which couples nodes of a cell; a row of D: volume that a patch gains; W: compliances of the
// patches. K itself couples nodes two edges apart and has six times as many entries. So products are made by
// parts, and what is factored is a combination mass M + stiffness K in its saddle form,
//
//   [ mass M + stiffness K_s    D^T            ]
//   [ D                         -W / stiffness ],
//
// with the pressures of patches as unknowns. It is quasi-definite: it has a factor L J L^T, J = diag(+-1),
// in every order of the unknowns. Source: R. Vanderbei, SIAM J. Optim. 5 (1995) 100.
#pragma once

#include "stylet/fem/volume_patch.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/petsc/owned.hpp"

#include <span>
#include <vector>

namespace stylet {

class SplitStiffness {
 public:
  /// Collective. first_node: as of TissueOperator; columns: nodes that share a cell with an owned one.
  SplitStiffness(MPI_Comm comm,
                 const Mesh& mesh,
                 const std::vector<int>& first_node,
                 const std::vector<std::vector<int>>& columns);

  /// Of an owned node: three rows of K_s, [component][3 column + component].
  void set_shear(int node, std::span<const int> columns, std::span<const double> rows);
  void set_patches(int node, std::span<const VolumePatch<3>> patches);
  /// Collective, when all of that is set.
  void assemble();

  /// Collective. y = K x.
  void multiply(Vec x, Vec y) const;
  /// Collective. The saddle form: each rank's dofs, then its patches. One of mass and lumped is null. The same
  /// object each time.
  [[nodiscard]] Mat saddle(double of_mass, double of_stiffness, Mat mass, Vec lumped);

 private:
  void preallocate();
  [[nodiscard]] PetscInt row_of_dof(PetscInt dof) const;

  MPI_Comm comm_;
  std::vector<int> first_node_;
  std::size_t rank_;
  std::vector<std::vector<int>> columns_;  ///< of owned nodes
  std::vector<int> first_patch_;           ///< of a node
  OwnedMat shear_;
  OwnedMat divergence_;  ///< D
  OwnedVec stiffness_;   ///< W^-1
  OwnedVec pressure_;
  OwnedMat saddle_;
};

}  // namespace stylet
