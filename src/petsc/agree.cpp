#include "stylet/petsc/agree.hpp"

#include "stylet/petsc/session.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

namespace stylet {

namespace {

void broadcast(MPI_Comm comm, std::string& text, int root) {
  auto size = static_cast<unsigned long long>(text.size());
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG_LONG, root, comm);
  text.resize(size);
  constexpr unsigned long long piece = 1ULL << 30;  // MPI counts are int
  for (unsigned long long at = 0; at < size; at += piece) {
    const int n = static_cast<int>(std::min(piece, size - at));
    MPI_Bcast(text.data() + at, n, MPI_CHAR, root, comm);
  }
}

}  // namespace

void agree(MPI_Comm comm, const std::optional<Failure>& failure) {
  const int none = size_of(comm);
  int mine = failure ? rank_of(comm) : none;
  int first = none;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, comm);
  if (first == none) return;
  int code = failure ? static_cast<int>(failure->code) : 0;
  std::string message = failure ? failure->message : std::string();
  MPI_Bcast(&code, 1, MPI_INT, first, comm);
  broadcast(comm, message, first);
  throw Error(static_cast<ExitCode>(code), message);
}

std::string read_on_all(MPI_Comm comm, const std::string& path) {
  std::string text;
  agree_after(comm, [&] {
    if (rank_of(comm) == 0) text = read_file(path);
  });
  broadcast(comm, text, 0);
  return text;
}

std::string read_file(const std::string& path) {
  const auto fail = [&](int reason) {
    const std::string message = path + ": cannot be read: ";
    if (reason == EISDIR) throw InputError(message + "is a folder");
    // A name that leads nowhere is wrong input; a disk or a server may be well again later.
    const bool is_wrong =
        reason == ENOENT || reason == ENOTDIR || reason == ENAMETOOLONG || reason == ELOOP;
    throw Error(is_wrong ? ExitCode::bad_input : ExitCode::io, message + std::strerror(reason));
  };
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail(errno);
  struct stat status {};
  const bool is_known = ::fstat(descriptor, &status) == 0;
  const auto refuse = [&](const char* why) {
    ::close(descriptor);
    throw InputError(path + ": cannot be read: " + why);
  };
  // /dev/zero has no end.
  const bool is_device = is_known && (S_ISCHR(status.st_mode) || S_ISBLK(status.st_mode));
  if (is_device && ::isatty(descriptor) == 0) refuse("is a device");
  constexpr std::size_t most_of_pipe = 1 << 30;  // bytes
  const bool is_file = is_known && S_ISREG(status.st_mode);
  std::string text;
  std::vector<char> piece(1 << 20);
  while (true) {
    const ssize_t n = ::read(descriptor, piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int reason = errno;
      ::close(descriptor);
      if (n < 0) fail(reason);
      return text;
    }
    text.append(piece.data(), static_cast<std::size_t>(n));
    if (!is_file && text.size() > most_of_pipe) refuse("is no file, and has over 1 GiB");
  }
}

}  // namespace stylet
