#include "stylet/simulation/cell_stress.hpp"

#include "stylet/fem/simplex.hpp"

#include <array>

namespace stylet {

namespace {

// In the frame of a scene in the plane, which may be turned against the mesh's.
LinearSimplex<2>::Block plane_gradient(const Simulation& simulation,
                                       int cell,
                                       std::span<const double> u) {
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
  return LinearSimplex<2>({x[0], x[1], x[2]}).displacement_gradient(corners);
}

}  // namespace

CellStress stress_in(const Simulation& simulation,
                     int cell,
                     std::span<const double> u,
                     PatchPressures& known) {
  const Mesh& mesh = simulation.mesh();
  const double mu = simulation.tissue().moduli(cell).mu;
  const auto [pressure, volume_energy] = simulation.tissue().volumetric(mesh, cell, u, known);
  if (mesh.dim() == 3) {
    const auto h = gradient_at(mesh, cell, {0.25, 0.25, 0.25, 0.25}, u);
    double shear = 0;  // the mean over the cell
    if (mesh.is_quadratic()) {
      for (const auto& point : tetrahedron_points()) {
        shear += shear_energy_density(gradient_at(mesh, cell, point, u), mu) / 4;
      }
    } else {
      shear = shear_energy_density(h, mu);
    }
    return {space_stress(h, mu, pressure), pressure, volume_energy + shear};
  }
  const auto h = plane_gradient(simulation, cell, u);
  return {plane_stress(h, mu, pressure, *simulation.scene().tissue.plane), pressure,
          volume_energy + shear_energy_density(h, mu)};
}

}  // namespace stylet
