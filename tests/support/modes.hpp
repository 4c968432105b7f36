// Modes of small bodies by a dense solver, as an independent reference.
#pragma once

#include "support/body.hpp"
#include <petscblaslapack.h>

namespace stylet {

/// shapes[i][dof]: mode i, M-orthonormal, zero at held dofs; squares: omega^2 (rad/s)^2, ascending.
struct DenseModes {
  std::vector<double> squares;
  std::vector<std::vector<double>> shapes;
};

inline double entry(Mat matrix, int row, int column) {
  PetscScalar value = 0;
  check(MatGetValue(matrix, row, column, &value));
  return value;
}

inline DenseModes dense_modes(const TissueOperator& tissue, std::span<const int> held_dofs) {
  const auto free = others(tissue, held_dofs);
  auto n = static_cast<PetscBLASInt>(free.size());
  const auto size = free.size();
  std::vector<double> k(size * size);
  std::vector<double> m(size * size, 0.0);
  std::vector<double> lumped;
  if (tissue.mass() == nullptr) lumped = gather_all(tissue.lumped_mass());
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < size; ++j) {
      k[i * size + j] = entry(tissue.stiffness(), free[i], free[j]);
      if (tissue.mass() != nullptr) m[i * size + j] = entry(tissue.mass(), free[i], free[j]);
    }
    if (!lumped.empty()) m[i * size + i] = lumped[static_cast<std::size_t>(free[i])];
  }
  DenseModes modes;
  modes.squares.resize(size);
  PetscBLASInt kind = 1;
  PetscBLASInt info = 0;
  auto room = static_cast<PetscBLASInt>(34 * size);
  std::vector<double> work(34 * size);
  LAPACKsygv_(&kind, "V", "U", &n, k.data(), &n, m.data(), &n, modes.squares.data(), work.data(),
              &room, &info);
  if (info != 0) throw std::runtime_error("dense eigenvalue solver failed");
  for (std::size_t i = 0; i < size; ++i) {
    auto& shape = modes.shapes.emplace_back(static_cast<std::size_t>(tissue.n_dofs()), 0.0);
    for (std::size_t j = 0; j < size; ++j)
      shape[static_cast<std::size_t>(free[j])] = k[i * size + j];
  }
  return modes;
}

/// Ascending; matrix: n x n.
inline std::vector<double> symmetric_eigenvalues(std::vector<double> matrix) {
  const auto size = static_cast<std::size_t>(std::lround(std::sqrt(matrix.size())));
  auto n = static_cast<PetscBLASInt>(size);
  auto room = static_cast<PetscBLASInt>(34 * size);
  PetscBLASInt info = 0;
  std::vector<double> values(size);
  std::vector<double> work(34 * size);
  LAPACKsyev_("N", "U", &n, matrix.data(), &n, values.data(), work.data(), &room, &info);
  if (info != 0) throw std::runtime_error("dense eigenvalue solver failed");
  return values;
}

}  // namespace stylet
