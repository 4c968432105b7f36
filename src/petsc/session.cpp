#include "stylet/petsc/session.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/message.hpp"
#include "stylet/petsc/check.hpp"

#include <slepcsys.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <new>
#include <omp.h>
#include <span>
#include <string>
#include <thread>
#include <unistd.h>

namespace stylet {

#if defined(PETSC_USE_COMPLEX) || defined(PETSC_USE_64BIT_INDICES) || \
    !defined(PETSC_USE_REAL_DOUBLE)
#error "Stylet needs PETSc with real double scalars and 32-bit indices"
#endif

namespace {

/// What PETSc and udunits2 would read beside the command line changes results and is seen by nobody.
void forget_environment() {
  for (const char* name : {"PETSC_OPTIONS", "PETSC_OPTIONS_YAML", "UDUNITS2_XML_PATH"}) {
    ::unsetenv(name);
  }
}

/// Open MPI starts a daemon beside a process that no mpirun started, for spawning others; we spawn none.
void start_no_daemon() {
  ::setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
}

/// A file must not be opened as standard output, whose text would land in it. Writing to what is
/// opened here fails, as it does to what is closed.
void fill_closed_streams() {
  int descriptor = 0;
  while (descriptor >= 0 && descriptor <= STDERR_FILENO) {
    descriptor = ::open("/dev/null", O_RDONLY);
  }
  if (descriptor > STDERR_FILENO) ::close(descriptor);
}

/// By nohup, or a shell that started us in the background.
std::vector<int> ignored_signals() {
  std::vector<int> ignored;
  for (const int signal : {SIGHUP, SIGINT, SIGTERM}) {
    struct sigaction action {};
    if (::sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) {
      ignored.push_back(signal);
    }
  }
  return ignored;
}

int& most_on_a_machine() {
  static int n = 1;
  return n;
}

std::vector<std::string>& given_options() {
  static std::vector<std::string> options;
  return options;
}

/// "-ksp_rtol 1e-10" in one text.
std::vector<std::string> with_values(std::span<char* const> arguments) {
  std::vector<std::string> options;
  for (const std::string argument : arguments) {
    const bool is_name =
        argument.size() > 1 && argument[0] == '-' && std::isalpha(argument[1]) != 0;
    if (is_name || options.empty()) {
      options.push_back(argument);
    } else {
      options.back() += " " + argument;
    }
  }
  return options;
}

}  // namespace

Session::Session(int argc, char** argv) : exceptions_at_start_(std::uncaught_exceptions()) {
  const auto ignored = ignored_signals();
  fill_closed_streams();
  forget_environment();
  start_no_daemon();
  // -skip_petscrc has to stand among the options: ~/.petscrc, .petscrc and petscrc are not read.
  std::string name = "stylet";
  std::string skip = "-skip_petscrc";
  std::vector<char*> arguments{name.data(), skip.data()};
  if (argc > 1) arguments.insert(arguments.end(), argv + 1, argv + argc);
  given_options() = with_values(std::span(arguments).subspan(2));
  int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);  // as in main: MPI looks for the end
  char** all = arguments.data();
  PETSC_MPI_THREAD_REQUIRED = MPI_THREAD_SERIALIZED;  // the window steps in a thread of its own
  check(SlepcInitialize(&count, &all, nullptr, nullptr));
  check(PetscOptionsClearValue(nullptr, skip.c_str()));
  // Errors are returned and become exceptions (check); PETSc's own traceback would repeat them.
  check(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
  check(PetscPopSignalHandler());
  // An error of MPI ends the job where it happens, whatever -mpi_return_on_error says: the libraries
  // below PETSc (MUMPS, hypre, ScaLAPACK) do not look at what their MPI calls return.
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_ARE_FATAL);
  for (const int signal : ignored) std::signal(signal, SIG_IGN);  // PETSc has forgotten it
  use_in_this_thread();
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  most_on_a_machine() = size_of(machine);
  MPI_Comm_free(&machine);
  MPI_Allreduce(MPI_IN_PLACE, &most_on_a_machine(), 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is a failed write, not an end
}

// One thread a rank: CHOLMOD's loops over a front take four, whatever OMP_NUM_THREADS says, and a third
// longer for it.
void use_in_this_thread() {
  omp_set_max_active_levels(0);
}

int ranks_on_a_machine() {
  return most_on_a_machine();
}

Session::~Session() {
  if (std::uncaught_exceptions() > exceptions_at_start_) abort_job(EXIT_FAILURE);
  (void)SlepcFinalize();
}

int rank_of(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

int size_of(MPI_Comm comm) {
  int size = 0;
  MPI_Comm_size(comm, &size);
  return size;
}

void abort_job(int exit_code) {
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::abort();
}

bool all_here(MPI_Comm comm) {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(comm, &request);
  int here = 0;
  constexpr int most_looks = 200;
  for (int i = 0; i < most_looks && here == 0; ++i) {
    // A rank that waits in a collective of another kind makes this one fail, not wait.
    if (MPI_Test(&request, &here, MPI_STATUS_IGNORE) != MPI_SUCCESS) return false;
    if (here == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return here != 0;
}

namespace {

int fail(int code, const std::string& message) {
  const bool together = all_here(MPI_COMM_WORLD);
  const int rank = rank_of(MPI_COMM_WORLD);
  if (!together) {
    std::fprintf(stderr, "stylet: rank %d alone: %s\n", rank, message.c_str());
    std::fflush(stderr);
    abort_job(code);
  }
  if (rank == 0) std::fprintf(stderr, "stylet: %s\n", message.c_str());
  return code;
}

/// Output that did not arrive is a failure, though all else went well.
int with_output_written(int code) {
  int reason = std::fflush(stdout) != 0 ? errno : 0;
  if (reason == 0 && std::ferror(stdout) != 0) reason = EIO;  // an earlier write
  MPI_Allreduce(MPI_IN_PLACE, &reason, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  if (reason == 0) return code;
  return fail(static_cast<int>(ExitCode::io),
              std::string("standard output cannot be written: ") + std::strerror(reason));
}

}  // namespace

int run_guarded(const std::function<int()>& body) {
  try {
    return with_output_written(body());
  } catch (const Error& error) {
    return fail(static_cast<int>(error.code()), error.what());
  } catch (const Stopped& stopped) {
    return fail(stopped.code(), stopped.what());
  } catch (const std::exception& error) {
    return fail(EXIT_FAILURE, message_of(error));
  } catch (...) {
    return fail(EXIT_FAILURE, "internal error");
  }
}

const std::vector<std::string>& solver_options() {
  return given_options();
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
