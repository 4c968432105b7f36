// The element of a cell of a mesh.
#pragma once

#include "stylet/fem/element.hpp"
#include "stylet/fem/quadratic_tetrahedron.hpp"
#include "stylet/mesh/mesh.hpp"

namespace stylet {

/// Dim: of the mesh.
template <int Dim>
LinearSimplex<Dim> simplex(const Mesh& mesh, int cell) {
  const auto nodes = mesh.cell(cell);
  std::array<std::span<const double>, Dim + 1> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) corners[k] = mesh.coordinates(nodes[k]);
  return LinearSimplex<Dim>(corners);
}

/// Displacements of the corners of a cell. u: of all dofs (m).
template <int Dim>
std::array<typename LinearSimplex<Dim>::Vector, Dim + 1> corner_values(const Mesh& mesh,
                                                                       int cell,
                                                                       std::span<const double> u) {
  const auto nodes = mesh.cell(cell);
  std::array<typename LinearSimplex<Dim>::Vector, Dim + 1> values{};
  for (std::size_t a = 0; a < values.size(); ++a) {
    for (std::size_t i = 0; i < Dim; ++i) {
      values[a][i] = u[Dim * static_cast<std::size_t>(nodes[a]) + i];
    }
  }
  return values;
}

/// Displacement gradient in a tetrahedron, linear or quadratic, at barycentric coordinates `l`. u: of all
/// dofs (m).
LinearSimplex<3>::Block gradient_at(const Mesh& mesh,
                                    int cell,
                                    const std::array<double, 4>& l,
                                    std::span<const double> u);

}  // namespace stylet
