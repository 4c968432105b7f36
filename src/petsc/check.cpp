#include "stylet/petsc/check.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <array>
#include <new>
#include <string>

namespace stylet {

namespace {
std::exception_ptr& pending() {
  static std::exception_ptr exception;
  return exception;
}
}  // namespace

void store_exception(std::exception_ptr exception) {
  if (!pending()) pending() = std::move(exception);
}

void check(PetscErrorCode code, const char* file, int line) {
  if (code == 0) return;
  if (pending()) std::rethrow_exception(std::exchange(pending(), nullptr));
  const char* text = nullptr;
  char* specific = nullptr;
  (void)PetscErrorMessage(code, &text, &specific);
  // Where memory runs out PETSc 3.18 returns the line of its source in place of PETSC_ERR_MEM.
  const bool is_code = code > PETSC_ERR_MIN_VALUE && code < PETSC_ERR_MAX_VALUE;
  if (code == PETSC_ERR_MEM || !is_code) throw std::bad_alloc();
  std::string message = "PETSc";
  if (text != nullptr) message += std::string(": ") + text;  // PETSC_ERR_USER has none
  if (specific != nullptr && *specific != '\0') message += std::string(": ") + specific;
  message += std::string(" (") + file + ":" + std::to_string(line) + ")";
  // Options: a name behind -ksp_type, -pc_type or -pc_factor_mat_solver_type that PETSc does not have, values
  // that do not fit.
  const bool is_input = code == PETSC_ERR_ARG_UNKNOWN_TYPE || code == PETSC_ERR_MISSING_FACTOR ||
                        code == PETSC_ERR_USER || code == PETSC_ERR_USER_INPUT;
  throw Error(is_input ? ExitCode::bad_input : ExitCode::other, message);
}

void check_options(PetscErrorCode code, const char* file, int line) {
  constexpr std::array arguments{PETSC_ERR_SUP, PETSC_ERR_ARG_SIZ, PETSC_ERR_ARG_WRONG,
                                 PETSC_ERR_ARG_OUTOFRANGE, PETSC_ERR_ARG_INCOMP};
  const auto& given = solver_options();
  const bool blames_them =
      !given.empty() && !pending() && std::ranges::find(arguments, code) != arguments.end();
  try {
    check(code, file, line);
  } catch (const Error& error) {
    if (!blames_them) throw;
    throw InputError("PETSc options " + join(given) + ": " + error.what());
  }
}

}  // namespace stylet
