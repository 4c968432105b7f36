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

/// Not collective. The bytes of a file. Throws InputError if there is no such file or it must not be
/// read, IoError where reading fails.
[[nodiscard]] std::string read_file(const std::string& path);

/// Collective. read_file on rank 0, sent to all.
std::string read_on_all(MPI_Comm comm, const std::string& path);

}  // namespace stylet
