// MPI, PETSc and SLEPc from start to end of the program.
#pragma once

#include <mpi.h>

namespace stylet {

/// Starts MPI and the libraries; stands outside the try block of main. If it is destroyed while an
/// exception is unwinding it aborts the job, because other ranks may wait in a collective call.
class Session {
 public:
  /// Collective. argc and argv are PETSc's options only.
  Session(int argc, char** argv);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

 private:
  int exceptions_at_start_;
};

[[nodiscard]] int rank_of(MPI_Comm comm);
[[nodiscard]] int size_of(MPI_Comm comm);

/// Ends all ranks at once with this exit code.
[[noreturn]] void abort_job(int exit_code);

}  // namespace stylet
