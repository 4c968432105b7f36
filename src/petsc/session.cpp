#include "stylet/petsc/session.hpp"

#include "stylet/petsc/check.hpp"

#include <slepcsys.h>

#include <cstdlib>
#include <exception>

namespace stylet {

#if defined(PETSC_USE_COMPLEX) || defined(PETSC_USE_64BIT_INDICES) || !defined(PETSC_USE_REAL_DOUBLE)
#error "Stylet needs PETSc with real double scalars and 32-bit indices"
#endif

Session::Session(int argc, char** argv) : exceptions_at_start_(std::uncaught_exceptions()) {
  check(SlepcInitialize(&argc, &argv, nullptr, nullptr));
  // Errors are returned and become exceptions (check); PETSc's own traceback would repeat them.
  check(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
  check(PetscPopSignalHandler());
}

Session::~Session() {
  if (std::uncaught_exceptions() > exceptions_at_start_) abort_job(EXIT_FAILURE);
  (void)SlepcFinalize();
}

int rank_of(MPI_Comm comm) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  return rank;
}

int size_of(MPI_Comm comm) {
  int size = 0;
  check_mpi(MPI_Comm_size(comm, &size));
  return size;
}

void abort_job(int exit_code) {
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::abort();
}

}  // namespace stylet
