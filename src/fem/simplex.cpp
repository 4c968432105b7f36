#include "stylet/fem/simplex.hpp"

namespace stylet {

LinearSimplex<3>::Block gradient_at(const Mesh& mesh,
                                    int cell,
                                    const std::array<double, 4>& l,
                                    std::span<const double> u) {
  const auto linear = simplex<3>(mesh, cell);
  if (!mesh.is_quadratic()) return linear.displacement_gradient(corner_values<3>(mesh, cell, u));
  const auto gradients = QuadraticTetrahedron(linear).gradients(l);
  const auto nodes = mesh.nodes(cell);
  LinearSimplex<3>::Block h{};
  for (std::size_t a = 0; a < gradients.size(); ++a) {
    const double* of_node = &u[3 * static_cast<std::size_t>(nodes[a])];
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) h[i][k] += of_node[i] * gradients[a][k];
    }
  }
  return h;
}

}  // namespace stylet
