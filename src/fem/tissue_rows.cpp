// Rows of K and masses of single nodes, from the cells around them.
#include "stylet/fem/tissue_operator.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"

#include <algorithm>

namespace stylet {

namespace {

constexpr std::size_t dim = 2;

std::size_t position(std::span<const int> sorted, int value) {
  return static_cast<std::size_t>(std::ranges::lower_bound(sorted, value) - sorted.begin());
}

LinearSimplex<2> simplex(const Mesh& mesh, int cell) {
  const auto n = mesh.cell(cell);
  return LinearSimplex<2>({mesh.coordinates(n[0]), mesh.coordinates(n[1]), mesh.coordinates(n[2])});
}

}  // namespace

std::vector<VolumePatch> TissueOperator::patches(const Mesh& mesh, int node) const {
  return volume_patches(mesh, node, [this](int cell) { return material(cell).moduli.lambda; });
}

// Rows of a node from the dilatation that the patches around it share.
void TissueOperator::add_shared_volume(const Mesh& mesh,
                                       int node,
                                       std::span<const int> columns,
                                       PatchCache& cache,
                                       std::vector<double>& rows) const {
  constexpr std::size_t several_fronts = 1 << 14;  // of nodes in the order of the numbering
  if (cache.size() > several_fronts) cache.clear();
  const std::size_t width = 2 * columns.size();
  for (const int centre : mesh.neighbours(node)) {
    const auto [found, is_new] = cache.try_emplace(centre);
    if (is_new) found->second = patches(mesh, centre);
    for (const VolumePatch& patch : found->second) {
      const auto* mine = patch.at(node);
      if (mine == nullptr) continue;
      const double factor = parameters_.thickness / patch.compliance;
      for (std::size_t b = 0; b < patch.nodes.size(); ++b) {
        const std::size_t at = 2 * position(columns, patch.nodes[b]);
        for (std::size_t i = 0; i < dim; ++i) {
          for (std::size_t k = 0; k < dim; ++k) {
            rows[i * width + at + k] += factor * ((*mine)[i] * patch.divergence[b][k]);
          }
        }
      }
    }
  }
}

VolumetricState TissueOperator::volumetric(const Mesh& mesh,
                                           int cell,
                                           std::span<const double> u) const {
  const double lambda = material(cell).moduli.lambda;
  VolumetricState state;
  const auto nodes = mesh.cell(cell);
  if (averaged()) {
    for (const int node : nodes) {
      const auto around = patches(mesh, node);
      const double p =
          std::ranges::find(around, mesh.region(cell), &VolumePatch::region)->pressure(u);
      state.pressure += p / 3;
      if (lambda > 0) state.energy_density += p * p / (6 * lambda);
    }
    return state;
  }
  const auto element = simplex(mesh, cell);
  double trace = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto dof = 2 * static_cast<std::size_t>(nodes[a]);
    trace += element.gradient[a][0] * u[dof] + element.gradient[a][1] * u[dof + 1];
  }
  return {lambda * trace, 0.5 * lambda * trace * trace};
}

void TissueOperator::fill_rows(const Mesh& mesh, std::span<const int> owned_nodes) {
  static const LogEvent event("StyletAssemble");
  const LogScope scope(event);
  PatchCache cache;
  Masses masses;
  const bool joins_anew =
      columns_of_ != mesh.connectivity_version();  // flips, of these nodes' cells
  columns_of_ = mesh.connectivity_version();
  PetscScalar* lumped = nullptr;
  check(VecGetArray(lumped_.get(), &lumped));
  for (const int node : owned_nodes) {
    NodeRows& rows = rows_[static_cast<std::size_t>(node - begin_)];
    if (joins_anew) rows.columns = averaged() ? nodes_within(mesh, node, 2) : mesh.neighbours(node);
    compute(mesh, node, {}, cache, rows, masses);
    const auto at = 2 * (node - begin_);
    lumped[at] = lumped[at + 1] = masses.lumped;
  }
  check(VecRestoreArray(lumped_.get(), &lumped));
}

// Rows of a node from all cells around it. mass_columns: empty if only the lumped mass is asked for.
void TissueOperator::compute(const Mesh& mesh,
                             int node,
                             std::span<const int> mass_columns,
                             PatchCache& cache,
                             NodeRows& rows,
                             Masses& masses) const {
  const double t = parameters_.thickness;
  const std::size_t width = 2 * rows.columns.size();
  rows.values.assign(2 * width, 0.0);
  masses.consistent.assign(mass_columns.size(), 0.0);
  masses.lumped = 0;
  for (const int cell : mesh.cells_around(node)) {
    const auto nodes = mesh.cell(cell);
    const auto element = simplex(mesh, cell);
    auto m = material(cell);
    if (averaged()) m.moduli.lambda = 0;  // see add_shared_volume
    const auto a = static_cast<std::size_t>(std::ranges::find(nodes, node) - nodes.begin());
    masses.lumped += t * m.density * element.lumped_mass();
    for (std::size_t b = 0; b < 3; ++b) {
      const std::size_t at = position(rows.columns, nodes[b]);
      const auto block = element.stiffness(a, b, m.moduli);
      for (std::size_t i = 0; i < dim; ++i) {
        for (std::size_t k = 0; k < dim; ++k) {
          rows.values[i * width + 2 * at + k] += t * block[i][k];
        }
      }
      if (mass_columns.empty()) continue;
      masses.consistent[position(mass_columns, nodes[b])] +=
          t * m.density * element.consistent_mass(a, b);
    }
  }
  if (averaged()) add_shared_volume(mesh, node, rows.columns, cache, rows.values);
}

}  // namespace stylet
