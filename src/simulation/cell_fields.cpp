#include "stylet/simulation/cell_fields.hpp"

#include "stylet/simulation/cell_stress.hpp"

#include <utility>
#include <vector>

namespace stylet {

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
  PatchPressures known;
  for (std::size_t i = 0; i < n; ++i) {
    const int c = new_of_old_cell[static_cast<std::size_t>(rows.begin) + i];
    const auto [s, pressure, density] = stress_in(simulation, c, u, known);
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
