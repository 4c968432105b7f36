#include "stylet/simulation/room.hpp"

#include "stylet/base/memory.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/solvers/whole_solver.hpp"

#include <cmath>

namespace stylet {

namespace {

double least(MPI_Comm comm, double bytes) {
  MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPI_DOUBLE, MPI_MIN, comm);
  return bytes;
}

}  // namespace

double bytes_needed(const Scene& scene, double n_cells, int ranks, double memory) {
  constexpr double program = 50e6;
  const bool factors = scene.time.method != TimeMethod::explicit_newmark;
  if (scene.dim() == 2) {
    constexpr double operators = 700;
    constexpr double with_factor = 2300;
    return program + (factors ? with_factor : operators) * n_cells;
  }
  struct Each {
    double operators;
    double with_matrices;  ///< bytes a cell
    double dofs;           ///< a cell
    double row;            ///< entries of a row of the operator
  };
  const auto formulation = scene.tissue.formulation;
  const Each each = formulation == Formulation::p2            ? Each{6500, 20000, 4.3, 82}
                    : formulation == Formulation::p1_averaged ? Each{2400, 8000, 0.55, 180}
                                                              : Each{600, 2000, 0.55, 42};
  if (!factors) return program + each.operators * n_cells;
  const double matrices = program + each.with_matrices * n_cells;
  const double n_dofs = each.dofs * n_cells;
  const double factor = factor_bytes(3, n_dofs, each.row);
  const double assembled = assembled_factor_bytes(3, n_dofs, each.row);
  switch (solver_for(factor, assembled, ranks, ranks_on_a_machine(), memory)) {
    case SolverKind::factor_everywhere:
      return matrices + factor;
    case SolverKind::factor_distributed:
      return matrices + 2 * assembled / ranks;
    case SolverKind::multigrid:
      break;
  }
  return 1.5 * matrices;  // with coarse levels and columns of the inverse
}

Room room_for(MPI_Comm comm, const Scene& scene, double n_cells, int refine) {
  const int ranks = ranks_on_a_machine();
  const double there = least(comm, memory_here());
  const double for_solvers = least(comm, memory_for_solvers());
  const auto refined = [&](int times) { return n_cells * std::pow(2.0, scene.dim() * times); };
  const auto needed = [&](int times) {
    return ranks * bytes_needed(scene, refined(times), size_of(comm), for_solvers);
  };
  Room room;
  while (needed(room.finest + 1) <= there && room.finest < refine) ++room.finest;
  if (room.finest >= refine) return room;
  const auto gigabytes = [](double bytes) { return brief(std::ceil(1e-8 * bytes) / 10) + " GB"; };
  room.lack = brief(refined(refine)) + " " + scene.cells() + ", which need about " +
              gigabytes(needed(refine)) + " of memory" +
              (ranks > 1 ? " on " + std::to_string(ranks) + " ranks" : "") + "; there are " +
              gigabytes(there);
  return room;
}

void require_room(MPI_Comm comm, const Scene& scene, double n_cells) {
  const Room room = room_for(comm, scene, n_cells, scene.mesh.refine);
  if (room.lack.empty()) return;
  const std::string makes = std::to_string(scene.mesh.refine) + " makes " + room.lack;
  if (room.finest >= 0) {
    refuse_key(scene, "mesh.refine",
               makes + "; allowed here: up to " + std::to_string(room.finest));
  }
  refuse_key(scene, "mesh", "has " + room.lack + "; allowed: a coarser mesh");
}

}  // namespace stylet
