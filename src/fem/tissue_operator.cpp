#include "stylet/fem/tissue_operator.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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

TissueOperator::TissueOperator(MPI_Comm comm,
                               const Mesh& mesh,
                               std::vector<int> first_node,
                               const TissueParameters& parameters,
                               std::function<bool(int)> needs_flips,
                               bool keeps_regions)
    : comm_(comm),
      first_node_(std::move(first_node)),
      parameters_(parameters),
      needs_flips_(std::move(needs_flips)),
      cell_region_(mesh.data().cell_region) {
  const auto rank = static_cast<std::size_t>(rank_of(comm));
  begin_ = first_node_[rank];
  end_ = first_node_[rank + 1];
  take_materials(mesh);
  if (needs_flips_ && (!uniform_ || keeps_regions)) region_map_.emplace(mesh);
  make_pattern(mesh);
}

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

void TissueOperator::make_pattern(const Mesh& mesh) {
  static const LogEvent event("StyletPattern");
  const LogScope scope(event);
  const int n_owned = end_ - begin_;
  stiffness_columns_.clear();
  mass_columns_.clear();
  for (int node = begin_; node < end_; ++node) {
    // A flip joins nodes two edges apart; averaged dilatation couples one edge further on each side.
    const int near = needs_flips_ && needs_flips_(node) ? 2 : 1;
    mass_columns_.push_back(nodes_within(mesh, node, near));
    stiffness_columns_.push_back(averaged() ? nodes_within(mesh, node, near + 1)
                                            : mass_columns_.back());
  }
  const auto make = [&](const std::vector<std::vector<int>>& columns, int columns_a_coupling) {
    std::vector<PetscInt> d;
    std::vector<PetscInt> o;
    for (const auto& coupled : columns) {
      const auto own = std::ranges::count_if(coupled, [&](int c) { return owns(c); });
      const auto far = static_cast<std::ptrdiff_t>(coupled.size()) - own;
      for (std::size_t k = 0; k < dim; ++k) {
        d.push_back(static_cast<PetscInt>(own) * columns_a_coupling);
        o.push_back(static_cast<PetscInt>(far) * columns_a_coupling);
      }
    }
    OwnedMat matrix;
    check(MatCreateAIJ(comm_, 2 * n_owned, 2 * n_owned, n_dofs(), n_dofs(), 0, d.data(), 0,
                       o.data(), matrix.put()));
    check(MatSetBlockSize(matrix.get(), 2));
    check(MatSetOption(matrix.get(), MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
    check(MatSetOption(matrix.get(), MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_TRUE));
    check(MatSetOption(matrix.get(), MAT_SYMMETRIC, PETSC_TRUE));
    check(MatSetOption(matrix.get(), MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
    return matrix;
  };
  stiffness_ = make(stiffness_columns_, 2);
  if (parameters_.mass == MassKind::consistent) {
    mass_ = make(mass_columns_, 1);
  } else {
    lumped_ = make_vector();
  }
  // Multigrid builds its coarse spaces from the rigid-body motions.
  OwnedVec places = make_vector();
  check(VecSetBlockSize(places.get(), 2));
  for (int node = begin_; node < end_; ++node) {
    const PetscScalar xy[2] = {mesh.point(node).x, mesh.point(node).y};
    check(VecSetValuesBlocked(places.get(), 1, &node, xy, INSERT_VALUES));
  }
  check(VecAssemblyBegin(places.get()));
  check(VecAssemblyEnd(places.get()));
  check(MatNullSpaceCreateRigidBody(places.get(), rigid_.put()));
  check(MatSetNearNullSpace(stiffness_.get(), rigid_.get()));
  if (tangent_) {
    tangent_ = make(stiffness_columns_, 2);
    check(MatSetNearNullSpace(tangent_.get(), rigid_.get()));
  }
  fill_all(mesh);
}

void TissueOperator::fill_all(const Mesh& mesh) {
  std::vector<int> all(static_cast<std::size_t>(end_ - begin_));
  std::iota(all.begin(), all.end(), begin_);
  fill(mesh, all);
}

void TissueOperator::expect_flips(const Mesh& mesh, std::function<bool(int)> needs_flips) {
  needs_flips_ = std::move(needs_flips);
  make_pattern(mesh);
}

OwnedVec TissueOperator::make_vector() const {
  OwnedVec vec;
  check(VecCreateMPI(comm_, 2 * (end_ - begin_), n_dofs(), vec.put()));
  return vec;
}

void TissueOperator::fill(const Mesh& mesh, std::span<const int> owned_nodes) {
  static const LogEvent event("StyletAssemble");
  const LogScope scope(event);
  std::vector<double> k_rows;
  std::vector<double> m_rows;
  std::vector<double> a_rows;
  std::vector<PetscInt> columns;
  PatchCache cache;
  const double t = parameters_.thickness;
  const bool consistent = parameters_.mass == MassKind::consistent;
  const auto c = tangent_combination_;
  for (const int node : owned_nodes) {
    const auto& coupled = stiffness_columns_[static_cast<std::size_t>(node - begin_)];
    const auto& mass_coupled = mass_columns_[static_cast<std::size_t>(node - begin_)];
    const std::size_t width = 2 * coupled.size();
    k_rows.assign(2 * width, 0.0);
    m_rows.assign(mass_coupled.size(), 0.0);
    double lumped = 0;
    for (const int cell : mesh.cells_around(node)) {
      const auto nodes = mesh.cell(cell);
      const auto element = simplex(mesh, cell);
      auto m = material(cell);
      if (averaged()) m.moduli.lambda = 0;  // see add_shared_volume
      const auto a = static_cast<std::size_t>(std::ranges::find(nodes, node) - nodes.begin());
      lumped += t * m.density * element.lumped_mass();
      for (std::size_t b = 0; b < 3; ++b) {
        const std::size_t at = position(coupled, nodes[b]);
        const auto block = element.stiffness(a, b, m.moduli);
        for (std::size_t i = 0; i < dim; ++i) {
          for (std::size_t k = 0; k < dim; ++k) {
            k_rows[i * width + 2 * at + k] += t * block[i][k];
          }
        }
        m_rows[position(mass_coupled, nodes[b])] += t * m.density * element.consistent_mass(a, b);
      }
    }
    if (averaged()) add_shared_volume(mesh, node, coupled, cache, k_rows);
    columns.resize(width);
    for (std::size_t j = 0; j < coupled.size(); ++j) {
      columns[2 * j] = 2 * coupled[j];
      columns[2 * j + 1] = 2 * coupled[j] + 1;
    }
    const PetscInt rows[2] = {2 * node, 2 * node + 1};
    const auto n = static_cast<PetscInt>(width);
    check(MatSetValues(stiffness_.get(), 2, rows, n, columns.data(), k_rows.data(), INSERT_VALUES));
    if (tangent_) {
      a_rows = k_rows;
      for (double& value : a_rows) value *= c.stiffness;
      const auto add_mass = [&](int column, double mass) {
        const std::size_t j = position(coupled, column);
        for (std::size_t i = 0; i < dim; ++i) a_rows[i * width + 2 * j + i] += c.mass * mass;
      };
      if (consistent) {
        for (std::size_t j = 0; j < m_rows.size(); ++j) add_mass(mass_coupled[j], m_rows[j]);
      } else {
        add_mass(node, lumped);
      }
      check(MatSetValues(tangent_.get(), 2, rows, n, columns.data(), a_rows.data(), INSERT_VALUES));
    }
    if (consistent) {
      std::vector<PetscInt> own(mass_coupled.size());
      for (PetscInt i = 0; i < 2; ++i) {
        for (std::size_t j = 0; j < own.size(); ++j) own[j] = 2 * mass_coupled[j] + i;
        check(MatSetValues(mass_.get(), 1, &rows[i], static_cast<PetscInt>(own.size()), own.data(),
                           m_rows.data(), INSERT_VALUES));
      }
    } else {
      const double both[2] = {lumped, lumped};
      check(VecSetValues(lumped_.get(), 2, rows, both, INSERT_VALUES));
    }
  }
  std::vector<Mat> matrices{stiffness_.get()};
  if (mass_) matrices.push_back(mass_.get());
  if (tangent_) matrices.push_back(tangent_.get());
  for (Mat matrix : matrices) {
    check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  }
  if (lumped_) {
    check(VecAssemblyBegin(lumped_.get()));
    check(VecAssemblyEnd(lumped_.get()));
  }
}

std::vector<int> TissueOperator::rows_of(const Mesh& mesh, std::span<const int> cells) const {
  std::vector<int> nodes;
  for (const int cell : cells) {
    for (const int node : mesh.cell(cell)) nodes.push_back(node);
  }
  sort_unique(nodes);
  if (!averaged()) return nodes;
  std::vector<int> wider;  // rows of a node know the cells around its neighbours
  for (const int node : nodes) {
    const auto around = mesh.neighbours(node);
    wider.insert(wider.end(), around.begin(), around.end());
  }
  sort_unique(wider);
  return wider;
}

std::vector<int> TissueOperator::coupled(const Mesh& mesh, std::span<const int> nodes) const {
  std::vector<int> all;
  for (const int node : nodes) {
    const auto around = nodes_within(mesh, node, averaged() ? 2 : 1);
    all.insert(all.end(), around.begin(), around.end());
  }
  sort_unique(all);
  return all;
}

bool TissueOperator::update(const Mesh& mesh, std::span<const int> touched_cells) {
  const std::vector<int> nodes = rows_of(mesh, touched_cells);
  remix(mesh, touched_cells);
  // The mesh is replicated, so every rank can see whether any owner lacks a coupling.
  int lacks = 0;
  std::vector<int> owned;
  for (const int node : nodes) {
    if (!owns(node)) continue;
    owned.push_back(node);
    const auto at = static_cast<std::size_t>(node - begin_);
    if (!std::ranges::includes(mass_columns_[at], mesh.neighbours(node))) lacks = 1;
    if (averaged() && !std::ranges::includes(stiffness_columns_[at], nodes_within(mesh, node, 2))) {
      lacks = 1;
    }
  }
  if (size_of(comm_) > 1) {
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &lacks, 1, MPI_INT, MPI_MAX, comm_));
  }
  if (lacks != 0) {
    make_pattern(mesh);
    return true;
  }
  fill(mesh, owned);
  return false;
}

void TissueOperator::apply_mass(Vec x, Vec y) const {
  if (mass_) {
    check(MatMult(mass_.get(), x, y));
  } else {
    check(VecPointwiseMult(y, lumped_.get(), x));
  }
}

Combination TissueOperator::tangent(double shift_v, double shift_a) const {
  const auto d = parameters_.damping.value_or(RayleighDamping{});
  return {shift_a + shift_v * d.mass_factor, 1 + shift_v * d.stiffness_factor};
}

void TissueOperator::make_tangent(Combination combination) {
  tangent_combination_ = combination;
  if (tangent_) {  // the same object: its factor keeps its pattern
    check(MatCopy(stiffness_.get(), tangent_.get(), SAME_NONZERO_PATTERN));
  } else {
    check(MatDuplicate(stiffness_.get(), MAT_COPY_VALUES, tangent_.put()));
  }
  check(MatSetNearNullSpace(tangent_.get(), rigid_.get()));
  check(MatSetOption(tangent_.get(), MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  check(MatScale(tangent_.get(), combination.stiffness));
  if (mass_) {
    check(MatAXPY(tangent_.get(), combination.mass, mass_.get(), SUBSET_NONZERO_PATTERN));
  } else {
    OwnedVec diagonal = make_vector();
    check(VecCopy(lumped_.get(), diagonal.get()));
    check(VecScale(diagonal.get(), combination.mass));
    check(MatDiagonalSet(tangent_.get(), diagonal.get(), ADD_VALUES));
  }
}

}  // namespace stylet
