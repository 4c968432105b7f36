// Products with K and with the consistent mass. In the plane cell by cell: the numbers that the
// assembled matrices give, from a fraction of their bytes. In space by those matrices.
#pragma once

#include "stylet/fem/cell_kernel.hpp"
#include "stylet/fem/tissue_operator.hpp"
#include "stylet/petsc/owned.hpp"

#include <span>
#include <vector>

namespace stylet {

class CellOperator {
 public:
  /// Collective. The tissue is lent.
  CellOperator(const Mesh& mesh, const TissueOperator& tissue);

  /// Collective, after the tissue's update. Takes these cells anew; true if flips brought in other
  /// nodes, so that local numbers are others too.
  bool update(const Mesh& mesh, std::span<const int> cells);

  /// Collective. y = K x.
  void stiffness(Vec x, Vec y);
  /// Collective. kx = K x and mz = M z, in one pass where M is consistent.
  void stiffness_and_mass(Vec x, Vec z, Vec kx, Vec mz);

  /// 2D.
  [[nodiscard]] const CellKernel& kernel() const { return cells_; }
  /// A vector of dofs with the ghosts of the kernel.
  [[nodiscard]] OwnedVec make_ghosted() const;

 private:
  void make(const Mesh& mesh);
  void multiply(Vec x, Vec z, Vec kx, Vec mz);

  const TissueOperator& tissue_;
  CellKernel cells_;
  OwnedVec ghosted_[2];  ///< on several ranks
  std::vector<double> force_[2];
  std::vector<double> pressure_;
};

}  // namespace stylet
