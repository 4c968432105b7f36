// PETSc error codes become exceptions, and exceptions cross C callbacks.
#pragma once

#include <petscsys.h>

#include <exception>
#include <utility>

namespace stylet {

/// Throws if a PETSc call failed: the exception that `guard` stored if there is one, otherwise an
/// Error with PETSc's text and the place of the call.
void check(PetscErrorCode code, const char* file = __builtin_FILE(), int line = __builtin_LINE());

/// The same of a call that reads PETSc's options, at once or when a solver is set up: what it finds wrong
/// with its arguments is the user's, if there are options. Throws InputError that names them.
void check_options(PetscErrorCode code,
                   const char* file = __builtin_FILE(),
                   int line = __builtin_LINE());

void store_exception(std::exception_ptr exception);

/// Runs the body of a callback that PETSc calls. What it throws is kept and thrown again by the
/// `check` around the PETSc call that led here.
template <class Body>
PetscErrorCode guard(Body&& body) noexcept {
  try {
    std::forward<Body>(body)();
    return PetscErrorCode{};
  } catch (...) {
    store_exception(std::current_exception());
    return PETSC_ERR_LIB;
  }
}

}  // namespace stylet
