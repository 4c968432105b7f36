#include "stylet/fem/split_stiffness.hpp"

#include "stylet/base/index.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>

namespace stylet {

namespace {

constexpr int dim = 3;

int n_patches(const Mesh& mesh, int node) {
  std::vector<int> regions;
  for (const int c : mesh.cells_around(node)) regions.push_back(mesh.region(c));
  sort_unique(regions);
  return static_cast<int>(regions.size());
}

OwnedMat make_matrix(MPI_Comm comm,
                     PetscInt n_rows,
                     PetscInt n_columns,
                     const std::vector<PetscInt>& near,
                     const std::vector<PetscInt>& far) {
  OwnedMat matrix;
  check(MatCreateAIJ(comm, n_rows, n_columns, PETSC_DETERMINE, PETSC_DETERMINE, 0, near.data(), 0,
                     far.data(), matrix.put()));
  check(MatSetOption(matrix.get(), MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_TRUE));
  return matrix;
}

void assemble(Mat matrix) {
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

// Calls each(column, value) along an owned row; with zeros, so that no pattern hangs on numbers.
template <class Each>
void along(Mat matrix, PetscInt row, Each&& each) {
  PetscInt n = 0;
  const PetscInt* columns = nullptr;
  const PetscScalar* values = nullptr;
  check(MatGetRow(matrix, row, &n, &columns, &values));
  for (PetscInt i = 0; i < n; ++i) each(columns[i], values[i]);
  check(MatRestoreRow(matrix, row, &n, &columns, &values));
}

}  // namespace

SplitStiffness::SplitStiffness(MPI_Comm comm,
                               const Mesh& mesh,
                               const std::vector<int>& first_node,
                               const std::vector<std::vector<int>>& columns)
    : comm_(comm), first_node_(first_node), rank_(at(rank_of(comm))), columns_(columns) {
  first_patch_.push_back(0);
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    first_patch_.push_back(first_patch_.back() + n_patches(mesh, node));
  }
  const int begin = first_node_[rank_];
  const int end = first_node_[rank_ + 1];
  std::vector<PetscInt> near[2];  // rows of dofs, of patches
  std::vector<PetscInt> far[2];
  for (int node = begin; node < end; ++node) {
    const auto& coupled = columns_[at(node - begin)];
    const auto own = static_cast<PetscInt>(
        std::ranges::count_if(coupled, [&](int c) { return c >= begin && c < end; }));
    const PetscInt others = static_cast<PetscInt>(coupled.size()) - own;
    near[0].insert(near[0].end(), dim, dim * own);
    far[0].insert(far[0].end(), dim, dim * others);
    const std::size_t patches = at(first_patch_[at(node) + 1] - first_patch_[at(node)]);
    near[1].insert(near[1].end(), patches, dim * own);
    far[1].insert(far[1].end(), patches, dim * others);
  }
  const PetscInt n_dofs = dim * (end - begin);
  const PetscInt n_rows = first_patch_[at(end)] - first_patch_[at(begin)];
  shear_ = make_matrix(comm_, n_dofs, n_dofs, near[0], far[0]);
  divergence_ = make_matrix(comm_, n_rows, n_dofs, near[1], far[1]);
  for (Mat matrix : {shear_.get(), divergence_.get()}) {
    check(MatSetOption(matrix, MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  }
  check(MatCreateVecs(divergence_.get(), nullptr, stiffness_.put()));
  check(MatCreateVecs(divergence_.get(), nullptr, pressure_.put()));
}

void SplitStiffness::set_shear(int node,
                               std::span<const int> columns,
                               std::span<const double> rows) {
  std::vector<PetscInt> dofs;
  for (const int column : columns) {
    for (int i = 0; i < dim; ++i) dofs.push_back(dim * column + i);
  }
  const PetscInt own[dim] = {dim * node, dim * node + 1, dim * node + 2};
  check(MatSetValues(shear_.get(), dim, own, static_cast<PetscInt>(dofs.size()), dofs.data(),
                     rows.data(), INSERT_VALUES));
}

void SplitStiffness::set_patches(int node, std::span<const VolumePatch<3>> patches) {
  PetscInt row = first_patch_[at(node)];
  for (const auto& patch : patches) {
    std::vector<PetscInt> dofs;
    std::vector<double> values;
    for (std::size_t b = 0; b < patch.nodes.size(); ++b) {
      for (std::size_t i = 0; i < at(dim); ++i) {
        dofs.push_back(dim * patch.nodes[b] + static_cast<PetscInt>(i));
        values.push_back(patch.divergence[b][i]);
      }
    }
    check(MatSetValues(divergence_.get(), 1, &row, static_cast<PetscInt>(dofs.size()), dofs.data(),
                       values.data(), INSERT_VALUES));
    check(VecSetValue(stiffness_.get(), row, 1 / patch.compliance, INSERT_VALUES));
    ++row;
  }
}

void SplitStiffness::assemble() {
  stylet::assemble(shear_.get());
  stylet::assemble(divergence_.get());
  check(VecAssemblyBegin(stiffness_.get()));
  check(VecAssemblyEnd(stiffness_.get()));
}

void SplitStiffness::multiply(Vec x, Vec y) const {
  check(MatMult(shear_.get(), x, y));
  check(MatMult(divergence_.get(), x, pressure_.get()));
  check(VecPointwiseMult(pressure_.get(), pressure_.get(), stiffness_.get()));
  check(MatMultTransposeAdd(divergence_.get(), pressure_.get(), y, y));
}

// Of the saddle form.
PetscInt SplitStiffness::row_of_dof(PetscInt dof) const {
  const auto next = std::ranges::upper_bound(first_node_, dof / dim);
  return dof + first_patch_[at(*(next - 1))];
}

void SplitStiffness::preallocate() {
  const int begin = first_node_[rank_];
  const int end = first_node_[rank_ + 1];
  std::vector<PetscInt> near;
  std::vector<PetscInt> far;
  const auto patches = [&](int node) {
    return first_patch_[at(node) + 1] - first_patch_[at(node)];
  };
  for (const auto& coupled : columns_) {
    PetscInt n[2] = {0, 0};
    for (const int c : coupled) n[c >= begin && c < end ? 0 : 1] += dim + patches(c);
    near.insert(near.end(), dim, n[0]);
    far.insert(far.end(), dim, n[1]);
  }
  for (int node = begin; node < end; ++node) {
    PetscInt n[2] = {1, 0};
    for (const int c : columns_[at(node - begin)]) n[c >= begin && c < end ? 0 : 1] += dim;
    near.insert(near.end(), at(patches(node)), n[0]);
    far.insert(far.end(), at(patches(node)), n[1]);
  }
  const auto n_rows = static_cast<PetscInt>(near.size());
  saddle_ = make_matrix(comm_, n_rows, n_rows, near, far);
}

Mat SplitStiffness::saddle(double of_mass, double of_stiffness, Mat mass, Vec lumped) {
  if (saddle_) {
    check(MatZeroEntries(saddle_.get()));
  } else {
    preallocate();
  }
  Mat matrix = saddle_.get();
  const auto add = [&](PetscInt row, PetscInt column, double value) {
    check(MatSetValues(matrix, 1, &row, 1, &column, &value, ADD_VALUES));
  };
  const int begin = first_node_[rank_];
  const int end = first_node_[rank_ + 1];
  for (PetscInt dof = dim * begin; dof < dim * end; ++dof) {
    const PetscInt row = row_of_dof(dof);
    along(shear_.get(), dof, [&](PetscInt column, double value) {
      add(row, row_of_dof(column), of_stiffness * value);
    });
    if (mass != nullptr) {
      along(mass, dof,
            [&](PetscInt column, double value) { add(row, row_of_dof(column), of_mass * value); });
    } else {
      add(row, row, of_mass * Values(lumped)[dof]);
    }
  }
  const Values stiffness(stiffness_.get());
  for (PetscInt patch = first_patch_[at(begin)]; patch < first_patch_[at(end)]; ++patch) {
    const PetscInt row = dim * end + patch;
    const double k = stiffness[patch];
    add(row, row, k > 0 ? -1 / (k * of_stiffness) : -1);  // 0: it bears no pressure
    along(divergence_.get(), patch, [&](PetscInt dof, double value) {
      const double coupling = k > 0 ? value : 0;
      add(row, row_of_dof(dof), coupling);
      add(row_of_dof(dof), row, coupling);
    });
  }
  stylet::assemble(matrix);
  return matrix;
}

}  // namespace stylet
