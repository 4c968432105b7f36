// MPI, PETSc and SLEPc from start to end of the program.
#pragma once

#include <mpi.h>

#include <functional>
#include <string>
#include <vector>

namespace stylet {

/// Starts MPI and the libraries; stands outside the try block of main. If it is destroyed while an
/// exception is unwinding it aborts the job, because other ranks may wait in a collective call.
class Session {
 public:
  /// Collective. argc and argv are PETSc's options only; the environment and files named petscrc
  /// have no say.
  Session(int argc, char** argv);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

 private:
  int exceptions_at_start_;
};

/// In a thread other than the one of the session, before all else. One thread at a time may use MPI and
/// the libraries.
void use_in_this_thread();

[[nodiscard]] int rank_of(MPI_Comm comm);
[[nodiscard]] int size_of(MPI_Comm comm);
/// Of the session, where most stand on one machine: they share its memory, also where groups of them
/// run apart. Not collective.
[[nodiscard]] int ranks_on_a_machine();

/// Ends all ranks at once with this exit code.
[[noreturn]] void abort_job(int exit_code);

/// Whether all ranks get here within two seconds: an error that struck some of them only has left
/// the others waiting.
[[nodiscard]] bool all_here(MPI_Comm comm);

/// Runs the body of main and returns the exit code. An Error that all ranks throw is printed once.
/// If the error struck some ranks only, the rank is named and the job aborted with its exit code.
/// Standard output that could not be written is exit code `io`.
int run_guarded(const std::function<int()>& body);

/// The session's options as they were given, each with its value.
[[nodiscard]] const std::vector<std::string>& solver_options();

/// Collective. Throws InputError for PETSc options that nothing has asked for so far.
void check_unused_options();

}  // namespace stylet
