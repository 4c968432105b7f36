#include "stylet/output/disk_space.hpp"

#include "stylet/output/text_file.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace stylet {

namespace {

/// Behind the end of the file. 0 or the errno of the failure.
int reserve(int descriptor, int mode, off_t bytes) {
  struct stat file {};
  if (::fstat(descriptor, &file) != 0) return errno;
  if (::fallocate(descriptor, mode, file.st_size, bytes) == 0) return 0;
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

DiskReserve::DiskReserve(std::string path) : path_(std::move(path)) {}

void DiskReserve::require(std::uint64_t bytes) {
  const int descriptor = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) throw_io_error(path_, "cannot be opened");
  const int reason = reserve(descriptor, static_cast<off_t>(bytes));
  ::close(descriptor);
  if (reason == 0) return;
  errno = reason;
  throw_io_error(path_, "no room for " + std::to_string((bytes + 999999) / 1000000) + " MB more");
}

// For several times if that can be had, since file systems are slow at it.
int DiskReserve::reserve(int descriptor, off_t bytes) {
  constexpr off_t several = 32;
  constexpr off_t most = 1 << 22;
  struct stat file {};
  struct rlimit largest {};
  if (::fstat(descriptor, &file) != 0 || ::getrlimit(RLIMIT_FSIZE, &largest) != 0) return errno;
  const off_t end = file.st_size + bytes;
  if (static_cast<rlim_t>(end) > largest.rlim_cur) return EFBIG;
  if (end <= end_) return 0;
  const off_t ample = std::max(bytes, std::min(several * bytes, most));
  if (stylet::reserve(descriptor, FALLOC_FL_KEEP_SIZE, ample) == 0) {
    end_ = file.st_size + ample;
    return 0;
  }
  return stylet::reserve(descriptor, FALLOC_FL_KEEP_SIZE, bytes);
}

void DiskReserve::free() {
  struct stat file {};
  if (::stat(path_.c_str(), &file) != 0 || ::truncate(path_.c_str(), file.st_size) != 0) {
    throw_io_error(path_, "cannot be written");
  }
}

void require_room(const std::string& draft, const std::string& path, std::uint64_t bytes) {
  ::unlink(draft.c_str());  // of a run that was killed
  const int descriptor = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) throw_io_error(path, "cannot be created");
  const int reason = reserve(descriptor, 0, static_cast<off_t>(bytes));
  ::close(descriptor);
  ::unlink(draft.c_str());
  if (reason == 0) return;
  errno = reason;
  throw_io_error(path, "cannot be created");
}

}  // namespace stylet
