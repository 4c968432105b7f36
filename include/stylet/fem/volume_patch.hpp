// The cells of one region around a node, which share one mean dilatation (formulation p1_averaged).
//
// P1 displacements with a P1 pressure whose mass matrix is lumped and which is eliminated node by
// node and region by region:
//   p_n = ( sum_c |T_c|/n div u_c ) / ( sum_c |T_c| / (n lambda_c) ),   energy = 1/2 sum_n W_n p_n^2,
// with W_n the denominator and n = 3 corners of a triangle, 4 of a tetrahedron. The shear part 2 mu eps : eps stays element by element, so no mode of the
// displacement loses its stiffness. By the Cauchy-Schwarz inequality the energy is at most that of
// p1: bounds on eigenvalues of p1 hold. Source: Bonet and Burton, Commun. Numer. Meth. Engng 14
// (1998) 437, who average the volume ratio; the pressure form follows from theirs for small strain.
#pragma once

#include "stylet/fem/element.hpp"
#include "stylet/mesh/mesh.hpp"

#include <functional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace stylet {

/// Units of space; in the plane per metre of thickness.
template <int Dim>
struct VolumePatch {
  using Vector = typename LinearSimplex<Dim>::Vector;
  int region = 0;
  std::vector<int> nodes;          ///< ascending
  std::vector<Vector> divergence;  ///< int phi_n div N_b, of each node (m^2)
  double compliance = 0;           ///< int phi_n / lambda (m^3/Pa); W_n

  /// d divergence of a node or null.
  [[nodiscard]] const Vector* at(int node) const;
  /// p_n (Pa). u: displacements of all dofs (m).
  [[nodiscard]] double pressure(std::span<const double> u) const;
};

/// All patches of a node. lambda(cell): Pa. Dim: of the mesh.
template <int Dim>
[[nodiscard]] std::vector<VolumePatch<Dim>> volume_patches(
    const Mesh& mesh, int node, const std::function<double(int)>& lambda);

/// Pressures of a node's patches, by region (Pa), of the nodes that were asked for: of one mesh and one field of
/// displacements.
using PatchPressures = std::unordered_map<int, std::vector<std::pair<int, double>>>;

/// Nodes within `rings` edges of a node, itself among them; ascending.
[[nodiscard]] std::vector<int> nodes_within(const Mesh& mesh, int node, int rings);

}  // namespace stylet
