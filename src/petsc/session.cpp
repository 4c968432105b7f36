#include "stylet/petsc/session.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/check.hpp"

#include <slepcsys.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <omp.h>
#include <string>
#include <thread>

namespace stylet {

#if defined(PETSC_USE_COMPLEX) || defined(PETSC_USE_64BIT_INDICES) || \
    !defined(PETSC_USE_REAL_DOUBLE)
#error "Stylet needs PETSc with real double scalars and 32-bit indices"
#endif

Session::Session(int argc, char** argv) : exceptions_at_start_(std::uncaught_exceptions()) {
  check(SlepcInitialize(&argc, &argv, nullptr, nullptr));
  // Errors are returned and become exceptions (check); PETSc's own traceback would repeat them.
  check(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
  check(PetscPopSignalHandler());
  // One thread a rank: CHOLMOD's loops over a front take four, whatever OMP_NUM_THREADS says, and a
  // third longer for it.
  omp_set_max_active_levels(0);
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is a failed write, not an end
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

namespace {

void fail(int code, const std::string& message) {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(MPI_COMM_WORLD, &request);
  int all_here = 0;
  constexpr int most_looks = 200;
  for (int i = 0; i < most_looks && all_here == 0; ++i) {
    // A rank that waits in a collective of another kind makes this one fail, not wait.
    if (MPI_Test(&request, &all_here, MPI_STATUS_IGNORE) != MPI_SUCCESS) {
      all_here = 0;
      break;
    }
    if (all_here == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const int rank = rank_of(MPI_COMM_WORLD);
  if (all_here == 0) {
    std::fprintf(stderr, "stylet: rank %d alone: %s\n", rank, message.c_str());
    std::fflush(stderr);
    abort_job(code);
  }
  if (rank == 0) std::fprintf(stderr, "stylet: %s\n", message.c_str());
}

}  // namespace

int run_guarded(const std::function<int()>& body) {
  try {
    return body();
  } catch (const Error& error) {
    fail(static_cast<int>(error.code()), error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    fail(EXIT_FAILURE, "not enough memory for this scene; use a coarser mesh or a larger machine");
    return EXIT_FAILURE;
  } catch (const std::exception& error) {
    fail(EXIT_FAILURE, std::string("internal error: ") + error.what());
    return EXIT_FAILURE;
  }
}

void check_unused_options() {
  PetscInt n = 0;
  char** names = nullptr;
  char** values = nullptr;
  check(PetscOptionsLeftGet(nullptr, &n, &names, &values));
  std::string unused;
  for (PetscInt i = 0; i < n; ++i) {
    const std::string name = names[i];
    // Read when the session ends.
    if (name.starts_with("log_") || name.starts_with("options_") || name.starts_with("malloc")) {
      continue;
    }
    unused += (unused.empty() ? "-" : ", -") + name;
  }
  check(PetscOptionsLeftRestore(nullptr, &n, &names, &values));
  if (unused.empty()) return;
  throw InputError("PETSc option " + unused +
                   " was not used by any solver of this run; solver options are -ksp_* and -pc_*, "
                   "for modes -eps_* and -st_*");
}

}  // namespace stylet
