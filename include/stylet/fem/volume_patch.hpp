// The cells of one region around a node, which share one mean dilatation (formulation p1_averaged).
//
// P1 displacements with a P1 pressure whose mass matrix is lumped and which is eliminated node by
// node and region by region:
//   p_n = ( sum_c |T_c|/3 div u_c ) / ( sum_c |T_c| / (3 lambda_c) ),   energy = 1/2 sum_n W_n p_n^2,
// with W_n the denominator. The shear part 2 mu eps : eps stays element by element, so no mode of the
// displacement loses its stiffness. By the Cauchy-Schwarz inequality the energy is at most that of
// p1: bounds on eigenvalues of p1 hold. Source: Bonet and Burton, Commun. Numer. Meth. Engng 14
// (1998) 437, who average the volume ratio; the pressure form follows from theirs for small strain.
#pragma once

#include "stylet/fem/element.hpp"
#include "stylet/mesh/mesh.hpp"

#include <functional>
#include <span>
#include <vector>

namespace stylet {

struct VolumePatch {
  int region = 0;
  std::vector<int> nodes;                            ///< ascending
  std::vector<LinearSimplex<2>::Vector> divergence;  ///< int phi_n div N_b, of each node (m)
  double compliance = 0;                             ///< int phi_n / lambda (m^2/Pa); W_n

  /// d divergence of a node or null.
  [[nodiscard]] const LinearSimplex<2>::Vector* at(int node) const;
  /// p_n (Pa). u: displacements of all dofs (m).
  [[nodiscard]] double pressure(std::span<const double> u) const;
};

/// All patches of a node, per unit thickness. lambda(cell): Pa.
[[nodiscard]] std::vector<VolumePatch> volume_patches(const Mesh& mesh,
                                                      int node,
                                                      const std::function<double(int)>& lambda);

/// Nodes within `rings` edges of a node, itself among them; ascending.
[[nodiscard]] std::vector<int> nodes_within(const Mesh& mesh, int node, int rings);

}  // namespace stylet
