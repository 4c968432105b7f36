// Rows of K and masses of single nodes, from the cells around them.
#include "stylet/base/sorted.hpp"
#include "stylet/fem/simplex.hpp"
#include "stylet/fem/tissue_operator.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"

#include <algorithm>

namespace stylet {

template <int Dim>
std::vector<VolumePatch<Dim>> TissueOperator::patches(const Mesh& mesh, int node) const {
  return volume_patches<Dim>(mesh, node, [this](int cell) { return material(cell).moduli.lambda; });
}

template <int Dim>
const std::vector<VolumePatch<Dim>>& TissueOperator::patches(const Mesh& mesh,
                                                             int node,
                                                             PatchCache<Dim>& cache) const {
  constexpr std::size_t several_fronts = 1 << 14;  // of nodes in the order of the numbering
  if (cache.size() > several_fronts) cache.clear();
  const auto [found, is_new] = cache.try_emplace(node);
  if (is_new) found->second = patches<Dim>(mesh, node);
  return found->second;
}

// Rows of a node from the dilatation that the patches around it share.
template <int Dim>
void TissueOperator::add_shared_volume(const Mesh& mesh,
                                       int node,
                                       std::span<const int> columns,
                                       PatchCache<Dim>& cache,
                                       std::vector<double>& rows) const {
  const std::size_t width = Dim * columns.size();
  for (const int centre : mesh.neighbours(node)) {
    for (const VolumePatch<Dim>& patch : patches<Dim>(mesh, centre, cache)) {
      const auto* mine = patch.at(node);
      if (mine == nullptr) continue;
      const double factor = parameters_.depth() / patch.compliance;
      for (std::size_t b = 0; b < patch.nodes.size(); ++b) {
        const std::size_t at = Dim * position(columns, patch.nodes[b]);
        for (std::size_t i = 0; i < Dim; ++i) {
          for (std::size_t k = 0; k < Dim; ++k) {
            rows[i * width + at + k] += factor * ((*mine)[i] * patch.divergence[b][k]);
          }
        }
      }
    }
  }
}

VolumetricState TissueOperator::volumetric(const Mesh& mesh,
                                           int cell,
                                           std::span<const double> u,
                                           PatchPressures& known) const {
  return dim_ == 2 ? volumetric_in<2>(mesh, cell, u, known)
                   : volumetric_in<3>(mesh, cell, u, known);
}

template <int Dim>
VolumetricState TissueOperator::volumetric_in(const Mesh& mesh,
                                              int cell,
                                              std::span<const double> u,
                                              PatchPressures& known) const {
  constexpr int n_corners = Dim + 1;
  const double lambda = material(cell).moduli.lambda;
  VolumetricState state;
  const auto nodes = mesh.cell(cell);
  if (averaged()) {
    for (const int node : nodes) {
      const auto [found, is_new] = known.try_emplace(node);
      auto& around = found->second;
      if (is_new) {
        for (const auto& patch : patches<Dim>(mesh, node)) {
          around.emplace_back(patch.region, patch.pressure(u));
        }
      }
      const double p =
          std::ranges::find(around, mesh.region(cell), &std::pair<int, double>::first)->second;
      state.pressure += p / n_corners;
      if (lambda > 0) state.energy_density += p * p / (2 * n_corners * lambda);
    }
    return state;
  }
  if constexpr (Dim == 3) {
    if (mesh.is_quadratic()) {
      for (const auto& point : tetrahedron_points()) {
        const auto h = gradient_at(mesh, cell, point, u);
        const double dilatation = h[0][0] + h[1][1] + h[2][2];
        state.pressure += lambda * dilatation / 4;
        state.energy_density += 0.5 * lambda * dilatation * dilatation / 4;
      }
      return state;
    }
  }
  const auto element = simplex<Dim>(mesh, cell);
  double trace = 0;
  for (std::size_t a = 0; a < n_corners; ++a) {
    const auto dof = Dim * static_cast<std::size_t>(nodes[a]);
    double share = 0;
    for (std::size_t k = 0; k < Dim; ++k) share += element.gradient[a][k] * u[dof + k];
    trace += share;
  }
  return {lambda * trace, 0.5 * lambda * trace * trace};
}

// In the plane: for explicit runs.
void TissueOperator::fill_rows(const Mesh& mesh, std::span<const int> owned_nodes) {
  static const LogEvent event("StyletAssemble");
  const LogScope scope(event);
  PatchCache<2> cache;
  Masses masses;
  const bool joins_anew =
      columns_of_ != mesh.connectivity_version();  // flips, of these nodes' cells
  columns_of_ = mesh.connectivity_version();
  PetscScalar* lumped = nullptr;
  check(VecGetArray(lumped_.get(), &lumped));
  for (const int node : owned_nodes) {
    NodeRows& rows = rows_[static_cast<std::size_t>(node - begin_)];
    if (joins_anew) rows.columns = averaged() ? nodes_within(mesh, node, 2) : mesh.neighbours(node);
    compute<2>(mesh, node, {}, rows, masses);
    if (averaged()) add_shared_volume(mesh, node, rows.columns, cache, rows.values);
    const auto at = 2 * (node - begin_);
    lumped[at] = lumped[at + 1] = masses.lumped;
  }
  check(VecRestoreArray(lumped_.get(), &lumped));
}

// Rows of a node from all cells around it, without what is averaged. mass_columns: empty if only the lumped mass
// is asked for.
template <int Dim>
void TissueOperator::compute(const Mesh& mesh,
                             int node,
                             std::span<const int> mass_columns,
                             NodeRows& rows,
                             Masses& masses) const {
  const double t = parameters_.depth();
  const std::size_t width = Dim * rows.columns.size();
  rows.values.assign(Dim * width, 0.0);
  masses.consistent.assign(mass_columns.size(), 0.0);
  masses.lumped = 0;
  for (const int cell : mesh.cells_around(node)) {
    const auto nodes = mesh.nodes(cell);
    auto m = material(cell);
    if (averaged()) m.moduli.lambda = 0;  // see add_shared_volume
    const auto a = static_cast<std::size_t>(std::ranges::find(nodes, node) - nodes.begin());
    const auto add = [&](const auto& element) {
      masses.lumped += t * m.density * element.lumped_mass(a);
      for (std::size_t b = 0; b < nodes.size(); ++b) {
        const std::size_t at = position(rows.columns, nodes[b]);
        const auto block = element.stiffness(a, b, m.moduli);
        for (std::size_t i = 0; i < Dim; ++i) {
          for (std::size_t k = 0; k < Dim; ++k) {
            rows.values[i * width + Dim * at + k] += t * block[i][k];
          }
        }
        if (mass_columns.empty()) continue;
        masses.consistent[position(mass_columns, nodes[b])] +=
            t * m.density * element.consistent_mass(a, b);
      }
    };
    if constexpr (Dim == 3) {
      if (mesh.is_quadratic()) {
        add(QuadraticTetrahedron(simplex<3>(mesh, cell)));
        continue;
      }
    }
    add(simplex<Dim>(mesh, cell));
  }
}

template void TissueOperator::compute<2>(
    const Mesh&, int, std::span<const int>, NodeRows&, Masses&) const;
template void TissueOperator::compute<3>(
    const Mesh&, int, std::span<const int>, NodeRows&, Masses&) const;
template void TissueOperator::add_shared_volume<2>(
    const Mesh&, int, std::span<const int>, PatchCache<2>&, std::vector<double>&) const;
template void TissueOperator::add_shared_volume<3>(
    const Mesh&, int, std::span<const int>, PatchCache<3>&, std::vector<double>&) const;
template const std::vector<VolumePatch<3>>& TissueOperator::patches<3>(const Mesh&,
                                                                       int,
                                                                       PatchCache<3>&) const;

}  // namespace stylet
