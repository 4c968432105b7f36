#include "stylet/simulation/room.hpp"

#include "stylet/base/memory.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"

#include <cmath>

namespace stylet {

namespace {

/// Of this communicator, on the machine where most of them are.
int ranks_on_a_machine(MPI_Comm comm) {
  MPI_Comm here = MPI_COMM_NULL;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
  int n = size_of(here);
  MPI_Comm_free(&here);
  MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPI_INT, MPI_MAX, comm);
  return n;
}

double least_memory(MPI_Comm comm) {
  double bytes = memory_here();
  MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPI_DOUBLE, MPI_MIN, comm);
  return bytes;
}

}  // namespace

double bytes_needed(const TimeParameters& time, double n_triangles) {
  constexpr double program = 50e6;
  constexpr double operators = 700;
  constexpr double with_factor = 2300;
  const bool factors = time.method != TimeMethod::explicit_newmark;
  return program + (factors ? with_factor : operators) * n_triangles;
}

// Factors of averaged tetrahedra with METIS have 14 n^1.46 numbers for n dofs, of which there are 0.55 a
// tetrahedron; half as much again is for what CHOLMOD works in.
double bytes_needed_in_space(const TimeParameters& time, double n_tetrahedra) {
  constexpr double program = 50e6;
  constexpr double operators = 4000;
  double bytes = program + operators * n_tetrahedra;
  if (time.method != TimeMethod::explicit_newmark) {
    bytes += 170 * std::pow(0.55 * n_tetrahedra, 1.46);
  }
  return bytes;
}

Room room_for(MPI_Comm comm, const TimeParameters& time, double n_cells, int refine, int dim) {
  const int ranks = ranks_on_a_machine(comm);
  const double there = least_memory(comm);
  const auto refined = [&](int times) { return n_cells * std::pow(2.0, dim * times); };
  const auto needed = [&](int times) {
    return ranks * (dim == 2 ? bytes_needed(time, refined(times))
                             : bytes_needed_in_space(time, refined(times)));
  };
  Room room;
  while (needed(room.finest + 1) <= there && room.finest < refine) ++room.finest;
  if (room.finest >= refine) return room;
  const auto gigabytes = [](double bytes) { return brief(std::ceil(1e-8 * bytes) / 10) + " GB"; };
  room.lack = brief(refined(refine)) + (dim == 2 ? " triangles" : " tetrahedra") +
              ", which need about " + gigabytes(needed(refine)) + " of memory" +
              (ranks > 1 ? " on " + std::to_string(ranks) + " ranks" : "") + "; there are " +
              gigabytes(there);
  return room;
}

void require_room(MPI_Comm comm, const Scene& scene, double n_cells) {
  const Room room = room_for(comm, scene.time, n_cells, scene.mesh.refine, scene.dim());
  if (room.lack.empty()) return;
  const std::string makes = std::to_string(scene.mesh.refine) + " makes " + room.lack;
  if (room.finest >= 0) {
    refuse_key(scene, "mesh.refine",
               makes + "; allowed here: up to " + std::to_string(room.finest));
  }
  refuse_key(scene, "mesh", "has " + room.lack + "; allowed: a coarser mesh");
}

}  // namespace stylet
