#include "stylet/output/disk_space.hpp"

#include "stylet/output/text_file.hpp"

#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace stylet {

namespace {

/// 0 or the errno of the failure.
int reserve(int descriptor, off_t bytes) {
  struct stat file {};
  if (::fstat(descriptor, &file) != 0) return errno;
  if (::fallocate(descriptor, 0, file.st_size, bytes) == 0) return 0;
  const int reason = errno;
  if (reason != EOPNOTSUPP && reason != ENOSYS) {
    // What was reserved before the disk was full is given back.
    return ::ftruncate(descriptor, file.st_size) == 0 ? reason : errno;
  }
  struct statvfs disk {};
  if (::fstatvfs(descriptor, &disk) != 0) return 0;  // unknown: let the write find out
  return disk.f_bavail < static_cast<std::uint64_t>(bytes) / disk.f_frsize ? ENOSPC : 0;
}

}  // namespace

void reserve_space(const std::string& path, std::uint64_t bytes) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) throw_io_error(path, "cannot be opened");
  const int reason = reserve(descriptor, static_cast<off_t>(bytes));
  ::close(descriptor);
  if (reason == 0) return;
  errno = reason;
  throw_io_error(path, "no room for " + std::to_string((bytes + 999999) / 1000000) + " MB more");
}

void require_room(const std::string& draft, const std::string& path, std::uint64_t bytes) {
  ::unlink(draft.c_str());  // of a run that was killed
  const int descriptor = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) throw_io_error(path, "cannot be created");
  const int reason = reserve(descriptor, static_cast<off_t>(bytes));
  ::close(descriptor);
  ::unlink(draft.c_str());
  if (reason == 0) return;
  errno = reason;
  throw_io_error(path, "cannot be created");
}

}  // namespace stylet
