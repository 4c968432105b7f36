#include "stylet/simulation/room.hpp"

#include "stylet/base/memory.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"

#include <cmath>

namespace stylet {

namespace {

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

Room room_for(MPI_Comm comm, const TimeParameters& time, double n_triangles, int refine) {
  const int ranks = ranks_on_a_machine();
  const double there = least_memory(comm);
  const auto needed = [&](int times) {
    return ranks * bytes_needed(time, n_triangles * std::pow(4.0, times));
  };
  Room room;
  while (needed(room.finest + 1) <= there && room.finest < refine) ++room.finest;
  if (room.finest >= refine) return room;
  const auto gigabytes = [](double bytes) { return brief(std::ceil(1e-8 * bytes) / 10) + " GB"; };
  room.lack = brief(n_triangles * std::pow(4.0, refine)) + " triangles, which need about " +
              gigabytes(needed(refine)) + " of memory" +
              (ranks > 1 ? " on " + std::to_string(ranks) + " ranks" : "") + "; there are " +
              gigabytes(there);
  return room;
}

void require_room(MPI_Comm comm, const Scene& scene, double n_triangles) {
  const Room room = room_for(comm, scene.time, n_triangles, scene.mesh.refine);
  if (room.lack.empty()) return;
  const std::string makes = std::to_string(scene.mesh.refine) + " makes " + room.lack;
  if (room.finest >= 0) {
    refuse_key(scene, "mesh.refine",
               makes + "; allowed here: up to " + std::to_string(room.finest));
  }
  refuse_key(scene, "mesh", "has " + room.lack + "; allowed: a coarser mesh");
}

}  // namespace stylet
