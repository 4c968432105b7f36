#include "stylet/petsc/agree.hpp"

#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace stylet {

namespace {

void broadcast(MPI_Comm comm, std::string& text, int root) {
  auto size = static_cast<unsigned long long>(text.size());
  check_mpi(MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG_LONG, root, comm));
  text.resize(size);
  constexpr unsigned long long piece = 1ULL << 30;  // MPI counts are int
  for (unsigned long long at = 0; at < size; at += piece) {
    const int n = static_cast<int>(std::min(piece, size - at));
    check_mpi(MPI_Bcast(text.data() + at, n, MPI_CHAR, root, comm));
  }
}

}  // namespace

void agree(MPI_Comm comm, const std::optional<Failure>& failure) {
  const int none = size_of(comm);
  int mine = failure ? rank_of(comm) : none;
  int first = none;
  check_mpi(MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, comm));
  if (first == none) return;
  int code = failure ? static_cast<int>(failure->code) : 0;
  std::string message = failure ? failure->message : std::string();
  check_mpi(MPI_Bcast(&code, 1, MPI_INT, first, comm));
  broadcast(comm, message, first);
  throw Error(static_cast<ExitCode>(code), message);
}

std::string read_on_all(MPI_Comm comm, const std::string& path) {
  std::string text;
  std::optional<Failure> failure;
  if (rank_of(comm) == 0) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream bytes;
    if (!file || std::filesystem::is_directory(path)) {
      const char* why = std::filesystem::is_directory(path) ? "is a folder" : std::strerror(errno);
      failure = Failure{ExitCode::bad_input, path + ": cannot be read: " + why};
    } else if (file.peek() != std::ifstream::traits_type::eof()) {
      bytes << file.rdbuf();
      text = std::move(bytes).str();
    }
  }
  agree(comm, failure);
  broadcast(comm, text, 0);
  return text;
}

}  // namespace stylet
