// MPI, PETSc and SLEPc from start to end of the program.
#pragma once

#include <mpi.h>

#include <functional>

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

/// Runs the body of main and returns the exit code. An Error that all ranks throw is printed once.
/// If the other ranks do not get here within two seconds the error struck some ranks only and the
/// others wait for them: then the rank is named and the job aborted with the error's exit code.
int run_guarded(const std::function<int()>& body);

/// Collective. Throws InputError for PETSc options that nothing has asked for so far.
void check_unused_options();

}  // namespace stylet
