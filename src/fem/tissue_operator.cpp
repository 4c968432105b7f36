#include "stylet/fem/tissue_operator.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace stylet {

TissueOperator::TissueOperator(MPI_Comm comm,
                               const Mesh& mesh,
                               std::vector<int> first_node,
                               const TissueParameters& parameters,
                               std::function<bool(int)> needs_flips,
                               Stiffness kept,
                               bool keeps_regions)
    : comm_(comm),
      dim_(mesh.dim()),
      first_node_(std::move(first_node)),
      parameters_(parameters),
      needs_flips_(std::move(needs_flips)),
      cell_region_(mesh.data().cell_region),
      kept_(kept) {
  if (parameters.dim() != dim_) {
    throw InputError(mesh.data().source +
                     (dim_ == 2 ? ": a mesh of triangles needs a plane"
                                : ": a mesh of tetrahedra has no plane") +
                     " (tissue.plane)");
  }
  if (mesh.is_quadratic() != (parameters.formulation == Formulation::p2)) {
    throw InputError(mesh.data().source + ": mid-edge nodes and tissue.formulation p2 go together");
  }
  const auto rank = static_cast<std::size_t>(rank_of(comm));
  begin_ = first_node_[rank];
  end_ = first_node_[rank + 1];
  take_materials(mesh);
  if (needs_flips_ && (!uniform_ || keeps_regions)) region_map_.emplace(mesh);
  make_pattern(mesh);
}

void TissueOperator::make_pattern(const Mesh& mesh) {
  static const LogEvent event("StyletPattern");
  const LogScope scope(event);
  const int n_owned = end_ - begin_;
  std::vector<int> all(static_cast<std::size_t>(n_owned));
  std::iota(all.begin(), all.end(), begin_);
  if (kept_ == Stiffness::rows) {
    rows_.resize(all.size());
    lumped_ = make_vector();
    fill_rows(mesh, all);
    return;
  }
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
      for (int k = 0; k < dim_; ++k) {
        d.push_back(static_cast<PetscInt>(own) * columns_a_coupling);
        o.push_back(static_cast<PetscInt>(far) * columns_a_coupling);
      }
    }
    OwnedMat matrix;
    check(MatCreateAIJ(comm_, dim_ * n_owned, dim_ * n_owned, n_dofs(), n_dofs(), 0, d.data(), 0,
                       o.data(), matrix.put()));
    check(MatSetBlockSize(matrix.get(), dim_));
    check(MatSetOption(matrix.get(), MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
    check(MatSetOption(matrix.get(), MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_TRUE));
    check(MatSetOption(matrix.get(), MAT_SYMMETRIC, PETSC_TRUE));
    check(MatSetOption(matrix.get(), MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
    return matrix;
  };
  stiffness_ = make(stiffness_columns_, dim_);
  if (parameters_.mass == MassKind::consistent) {
    mass_ = make(mass_columns_, 1);
  } else {
    lumped_ = make_vector();
  }
  if (dim_ == 3 && averaged()) split_.emplace(comm_, mesh, first_node_, mass_columns_);
  // Multigrid builds its coarse spaces from the rigid-body motions.
  OwnedVec places = make_vector();
  check(VecSetBlockSize(places.get(), dim_));
  for (int node = begin_; node < end_; ++node) {
    check(
        VecSetValuesBlocked(places.get(), 1, &node, mesh.coordinates(node).data(), INSERT_VALUES));
  }
  check(VecAssemblyBegin(places.get()));
  check(VecAssemblyEnd(places.get()));
  check(MatNullSpaceCreateRigidBody(places.get(), rigid_.put()));
  check(MatSetNearNullSpace(stiffness_.get(), rigid_.get()));
  if (tangent_) {
    tangent_ = make(stiffness_columns_, dim_);
    check(MatSetNearNullSpace(tangent_.get(), rigid_.get()));
  }
  fill(mesh, all);
}

void TissueOperator::fill_all(const Mesh& mesh) {
  std::vector<int> all(static_cast<std::size_t>(end_ - begin_));
  std::iota(all.begin(), all.end(), begin_);
  if (kept_ == Stiffness::rows) {
    fill_rows(mesh, all);
  } else {
    fill(mesh, all);
  }
}

void TissueOperator::expect_flips(const Mesh& mesh, std::function<bool(int)> needs_flips) {
  needs_flips_ = std::move(needs_flips);
  if (kept_ == Stiffness::matrix) make_pattern(mesh);
}

OwnedVec TissueOperator::make_vector() const {
  OwnedVec vec;
  check(VecCreateMPI(comm_, dim_ * (end_ - begin_), n_dofs(), vec.put()));
  return vec;
}

void TissueOperator::fill(const Mesh& mesh, std::span<const int> owned_nodes) {
  dim_ == 2 ? fill_matrices<2>(mesh, owned_nodes) : fill_matrices<3>(mesh, owned_nodes);
}

template <int Dim>
void TissueOperator::fill_matrices(const Mesh& mesh, std::span<const int> owned_nodes) {
  static const LogEvent event("StyletAssemble");
  const LogScope scope(event);
  NodeRows k;
  Masses masses;
  std::vector<double> a_rows;
  std::vector<PetscInt> columns;
  PatchCache<Dim> cache;
  std::vector<double> shear;
  const bool consistent = parameters_.mass == MassKind::consistent;
  const auto c = tangent_combination_;
  for (const int node : owned_nodes) {
    const auto& coupled = stiffness_columns_[static_cast<std::size_t>(node - begin_)];
    const auto& mass_coupled = mass_columns_[static_cast<std::size_t>(node - begin_)];
    const std::size_t width = Dim * coupled.size();
    k.columns = coupled;
    compute<Dim>(mesh, node, mass_coupled, k, masses);
    if constexpr (Dim == 3) {
      if (split_) {
        shear.clear();
        for (std::size_t i = 0; i < Dim; ++i) {
          for (const int column : mass_coupled) {
            const double* const block = &k.values[i * width + Dim * position(coupled, column)];
            shear.insert(shear.end(), block, block + Dim);
          }
        }
        split_->set_shear(node, mass_coupled, shear);
        split_->set_patches(node, patches<Dim>(mesh, node, cache));
      }
    }
    if (averaged()) add_shared_volume(mesh, node, coupled, cache, k.values);
    const std::vector<double>& k_rows = k.values;
    const std::vector<double>& m_rows = masses.consistent;
    const double lumped = masses.lumped;
    columns.resize(width);
    for (std::size_t j = 0; j < coupled.size(); ++j) {
      for (std::size_t i = 0; i < Dim; ++i) {
        columns[Dim * j + i] = Dim * coupled[j] + static_cast<int>(i);
      }
    }
    PetscInt rows[Dim];
    for (int i = 0; i < Dim; ++i) rows[i] = Dim * node + i;
    const auto n = static_cast<PetscInt>(width);
    check(
        MatSetValues(stiffness_.get(), Dim, rows, n, columns.data(), k_rows.data(), INSERT_VALUES));
    if (tangent_) {
      a_rows = k_rows;
      for (double& value : a_rows) value *= c.stiffness;
      const auto add_mass = [&](int column, double mass) {
        const std::size_t j = position(coupled, column);
        for (std::size_t i = 0; i < Dim; ++i) a_rows[i * width + Dim * j + i] += c.mass * mass;
      };
      if (consistent) {
        for (std::size_t j = 0; j < m_rows.size(); ++j) add_mass(mass_coupled[j], m_rows[j]);
      } else {
        add_mass(node, lumped);
      }
      check(
          MatSetValues(tangent_.get(), Dim, rows, n, columns.data(), a_rows.data(), INSERT_VALUES));
    }
    if (consistent) {
      std::vector<PetscInt> own(mass_coupled.size());
      for (PetscInt i = 0; i < Dim; ++i) {
        for (std::size_t j = 0; j < own.size(); ++j) own[j] = Dim * mass_coupled[j] + i;
        check(MatSetValues(mass_.get(), 1, &rows[i], static_cast<PetscInt>(own.size()), own.data(),
                           m_rows.data(), INSERT_VALUES));
      }
    } else {
      std::array<double, Dim> alike;
      alike.fill(lumped);
      check(VecSetValues(lumped_.get(), Dim, rows, alike.data(), INSERT_VALUES));
    }
  }
  if (split_) split_->assemble();
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
    for (const int node : mesh.nodes(cell)) nodes.push_back(node);
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
  const auto add = [&](std::span<const int> around) {
    all.insert(all.end(), around.begin(), around.end());
  };
  for (const int node : nodes) {
    if (kept_ == Stiffness::rows && owns(node)) {
      add(rows_[static_cast<std::size_t>(node - begin_)].columns);
    } else {
      add(nodes_within(mesh, node, averaged() ? 2 : 1));
    }
  }
  sort_unique(all);
  return all;
}

bool TissueOperator::update(const Mesh& mesh, std::span<const int> touched_cells) {
  const std::vector<int> nodes = rows_of(mesh, touched_cells);
  remix(mesh, touched_cells);
  if (kept_ == Stiffness::rows) {
    std::vector<int> mine;
    std::ranges::copy_if(nodes, std::back_inserter(mine), [&](int node) { return owns(node); });
    fill_rows(mesh, mine);
    return false;
  }
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
    MPI_Allreduce(MPI_IN_PLACE, &lacks, 1, MPI_INT, MPI_MAX, comm_);
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

void TissueOperator::apply_stiffness(Vec x, Vec y) const {
  if (split_) {
    split_->multiply(x, y);
    return;
  }
  if (kept_ == Stiffness::matrix) {
    check(MatMult(stiffness_.get(), x, y));
    return;
  }
  const auto all = gather_all(x);
  Entries product(y);
  for (int row = first_dof(); row < end_dof(); ++row) {
    double sum = 0;
    along_row(row, [&](int column, double value) {
      sum += value * all[static_cast<std::size_t>(column)];
    });
    product[row] = sum;
  }
}

Combination TissueOperator::tangent(double shift_v, double shift_a) const {
  const auto d = parameters_.damping.value_or(RayleighDamping{});
  return {shift_a + shift_v * d.mass_factor, 1 + shift_v * d.stiffness_factor};
}

Mat TissueOperator::saddle(Combination combination) {
  if (!split_) return nullptr;
  return split_->saddle(combination.mass, combination.stiffness, mass_.get(), lumped_.get());
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
