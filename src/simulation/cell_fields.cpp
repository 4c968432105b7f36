#include "stylet/simulation/cell_fields.hpp"

#include "stylet/fem/material.hpp"
#include "stylet/fem/simplex.hpp"

#include <utility>
#include <vector>

namespace stylet {

namespace {

// Stress and energy density of a cell, in the scene's frame.
struct CellState {
  Stress stress;
  double energy = 0;
};

CellState plane_state(const Simulation& simulation, int c, const std::vector<double>& u) {
  const Mesh& mesh = simulation.mesh();
  const Rotation turn = simulation.rotation();
  const auto nodes = mesh.cell(c);
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
  const double mu = simulation.tissue().moduli(c).mu;
  const VolumetricState volume = simulation.tissue().volumetric(mesh, c, u);
  return {plane_stress(h, mu, volume.pressure, *simulation.scene().tissue.plane),
          volume.energy_density + shear_energy_density(h, mu)};
}

CellState space_state(const Simulation& simulation, int c, const std::vector<double>& u) {
  const Mesh& mesh = simulation.mesh();
  const auto h = simplex<3>(mesh, c).displacement_gradient(corner_values<3>(mesh, c, u));
  const double mu = simulation.tissue().moduli(c).mu;
  const VolumetricState volume = simulation.tissue().volumetric(mesh, c, u);
  return {space_stress(h, mu, volume.pressure),
          volume.energy_density + shear_energy_density(h, mu)};
}

}  // namespace

void add_cell_fields(const Simulation& simulation,
                     std::span<const int> new_of_old_cell,
                     Range rows,
                     const std::vector<double>& u,
                     Snapshot& snapshot) {
  const auto n = static_cast<std::size_t>(rows.size());
  const Mesh& mesh = simulation.mesh();
  const bool in_space = mesh.dim() == 3;
  Field xx{"stress_xx", true, 1, std::vector<double>(n), "Pa"};
  Field yy{"stress_yy", true, 1, std::vector<double>(n), "Pa"};
  Field xy{"stress_xy", true, 1, std::vector<double>(n), "Pa"};
  Field zz{"stress_zz", true, 1, std::vector<double>(n), "Pa"};
  Field yz{"stress_yz", true, 1, std::vector<double>(n), "Pa"};
  Field zx{"stress_zx", true, 1, std::vector<double>(n), "Pa"};
  Field mises{"von_mises", true, 1, std::vector<double>(n), "Pa"};
  Field energy{"strain_energy_density", true, 1, std::vector<double>(n), "J/m^3"};
  FlagField region{"region", true, std::vector<int>(n)};
  for (std::size_t i = 0; i < n; ++i) {
    const int c = new_of_old_cell[static_cast<std::size_t>(rows.begin) + i];
    const auto [s, density] =
        in_space ? space_state(simulation, c, u) : plane_state(simulation, c, u);
    xx.values[i] = s.xx;
    yy.values[i] = s.yy;
    xy.values[i] = s.xy;
    zz.values[i] = s.zz;
    yz.values[i] = s.yz;
    zx.values[i] = s.zx;
    mises.values[i] = s.von_mises();
    energy.values[i] = density;
    region.values[i] = mesh.region(c);
  }
  for (Field* field : {&xx, &yy, &xy}) snapshot.fields.push_back(std::move(*field));
  if (in_space) {
    for (Field* field : {&zz, &yz, &zx}) snapshot.fields.push_back(std::move(*field));
  }
  for (Field* field : {&mises, &energy}) snapshot.fields.push_back(std::move(*field));
  snapshot.flags.push_back(std::move(region));
}

}  // namespace stylet
