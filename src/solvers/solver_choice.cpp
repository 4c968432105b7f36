// Which solver of the whole tissue there is room for.
#include "stylet/base/memory.hpp"
#include "stylet/solvers/whole_solver.hpp"

#include <algorithm>
#include <cmath>
#include <unistd.h>

namespace stylet {

double factor_bytes(int dim, double n_dofs, double entries_a_row) {
  // Measured on meshes of 1e5 to 1e6 triangles; n log n, so more than enough on smaller ones.
  constexpr double bytes_a_dof = 2400;
  if (dim == 2) return bytes_a_dof * n_dofs;
  // Nested dissection in space, measured on 4e4 to 1e6 tetrahedra of all kinds (jobs/README.md): from 3 % too
  // little to a third too much. Of averaged dilatation, whose rows are longest, the saddle form is factored.
  constexpr double most_entries = 180;
  return (70 + 0.4 * std::min(entries_a_row, most_entries)) * std::pow(n_dofs, 1.38);
}

double assembled_factor_bytes(int dim, double n_dofs, double entries_a_row) {
  const double bytes = factor_bytes(dim, n_dofs, entries_a_row);
  if (dim == 2) return bytes;
  return std::max(bytes, 1.5 * entries_a_row * std::pow(n_dofs, 1.38));
}

SolverKind solver_for(
    double factor, double assembled, int ranks, int ranks_of_machine, double machine_memory) {
  // While it is made a factor takes 1.3 times the room of its numbers, a distributed one twice.
  if (factor * ranks_of_machine < 0.5 * machine_memory) return SolverKind::factor_everywhere;
  if (ranks > 1 && 2 * assembled * ranks_of_machine / ranks < 0.65 * machine_memory) {
    return SolverKind::factor_distributed;
  }
  return SolverKind::multigrid;
}

double memory_for_solvers() {
  const double physical =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return std::min(physical, memory_here());
}

}  // namespace stylet
