// Failures that may strike one rank only become the same error on all ranks.
#pragma once

#include "stylet/base/errors.hpp"

#include <mpi.h>

#include <optional>
#include <string>

namespace stylet {

struct Failure {
  ExitCode code;
  std::string message;
};

/// Collective. If any rank has a failure, all ranks throw the error of the lowest such rank.
void agree(MPI_Comm comm, const std::optional<Failure>& failure);

/// Collective. Runs `body` on this rank and lets all ranks throw if it threw an Error anywhere.
/// The body must not hold collective calls.
template <class Body>
void agree_after(MPI_Comm comm, Body&& body) {
  std::optional<Failure> failure;
  try {
    body();
  } catch (const Error& error) {
    failure = Failure{error.code(), error.what()};
  }
  agree(comm, failure);
}

/// Collective. The bytes of a file, read on rank 0 and sent to all. Throws InputError if it cannot
/// be read.
std::string read_on_all(MPI_Comm comm, const std::string& path);

}  // namespace stylet
