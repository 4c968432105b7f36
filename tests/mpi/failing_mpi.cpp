// Fails in the way that its argument names; check_failure.py looks at how the job ends.
#include "stylet/base/errors.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <stdexcept>
#include <string>

namespace stylet {

namespace {

int fail(const std::string& mode) {
  const int rank = rank_of(MPI_COMM_WORLD);
  if (mode == "one_rank" && rank == 1) throw NumericalError("the step did not converge");
  if (mode == "unexpected" && rank == 1) throw std::logic_error("a broken promise");
  if (mode == "all_ranks") throw InputError("the scene is bad");
  if (mode == "agreed") {
    agree_after(MPI_COMM_WORLD, [&] {
      if (rank == 1) throw IoError("the disk of rank 1 is full");
    });
  }
  if (mode == "mpi" && rank == 1) MPI_Send(nullptr, 0, MPI_INT, 1000, 0, MPI_COMM_WORLD);
  MPI_Barrier(MPI_COMM_WORLD);  // where the others wait for rank 1
  return 0;
}

// An exception that passes by run_guarded: the session's destructor ends the job.
int unwind() {
  try {
    const Session session(0, nullptr);
    if (rank_of(MPI_COMM_WORLD) == 1) throw std::logic_error("past run_guarded");
    MPI_Barrier(MPI_COMM_WORLD);
    return 0;
  } catch (const std::exception&) {
    return 0;  // not reached: the destructor has aborted
  }
}

}  // namespace

}  // namespace stylet

int main(int argc, char** argv) {
  const std::string mode = argc > 1 ? argv[1] : "";
  if (mode == "unwinding") return stylet::unwind();
  const stylet::Session session(1, argv);
  return stylet::run_guarded([&] { return stylet::fail(mode); });
}
