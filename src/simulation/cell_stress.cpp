#include "stylet/simulation/cell_stress.hpp"

#include "stylet/fem/element.hpp"

#include <array>

namespace stylet {

CellStress stress_in(const Simulation& simulation, int cell, std::span<const double> u) {
  const Mesh& mesh = simulation.mesh();
  const Rotation turn = simulation.rotation();
  const auto nodes = mesh.cell(cell);
  std::array<LinearSimplex<2>::Vector, 3> x{};
  std::array<LinearSimplex<2>::Vector, 3> corners{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto at = 2 * static_cast<std::size_t>(nodes[k]);
    const auto point = turn.to_scene(mesh.point(nodes[k]));
    const Vector2 moved = turn.to_scene(Vector2{u[at], u[at + 1]});
    x[k] = {point.x, point.y};
    corners[k] = {moved.x, moved.y};
  }
  const LinearSimplex<2> element({x[0], x[1], x[2]});
  const auto h = element.displacement_gradient(corners);
  const double mu = simulation.tissue().moduli(cell).mu;
  const VolumetricState volume = simulation.tissue().volumetric(mesh, cell, u);
  return {plane_stress(h, mu, volume.pressure, simulation.scene().tissue.plane), volume.pressure,
          volume.energy_density + shear_energy_density(h, mu)};
}

}  // namespace stylet
