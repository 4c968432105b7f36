#include "stylet/output/folder_lock.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/text_file.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <sys/stat.h>
#include <unistd.h>

namespace stylet {

namespace {

/// When a process began, in the kernel's ticks: tells it from a later one of the same number.
std::string birth_of(long pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text);
  // The second field is the name in parentheses, which may hold anything; the birth is the 22nd.
  std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
  std::string birth;
  for (int i = 3; i <= 22; ++i) fields >> birth;
  return birth;
}

struct Holder {
  long pid = 0;
  std::string host;
  std::string birth;
  std::string since;

  [[nodiscard]] std::string text() const {
    return std::to_string(pid) + " " + host + " " + birth + " " + since + "\n";
  }
  [[nodiscard]] bool lives() const {
    return (::kill(static_cast<pid_t>(pid), 0) == 0 || errno == EPERM) && birth_of(pid) == birth;
  }
};

Holder this_process() {
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '?';
  std::array<char, 40> since{};
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::strftime(since.data(), since.size(), "%Y-%m-%d %H:%M:%S UTC", &utc);
  const long pid = ::getpid();
  return {pid, host.data(), birth_of(pid), since.data()};
}

Holder read_holder(int descriptor) {
  std::array<char, 500> bytes{};
  const ssize_t n = ::pread(descriptor, bytes.data(), bytes.size() - 1, 0);
  Holder holder;
  std::istringstream text(
      std::string(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(n, 0))));
  text >> holder.pid >> holder.host >> holder.birth >> std::ws;
  std::getline(text, holder.since);
  return holder;
}

}  // namespace

FolderLock::FolderLock(const std::string& folder)
    : folder_(folder), path_(folder + "/" + file_name) {
  while (!take()) ::close(descriptor_);
}

bool FolderLock::take() {
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor_ < 0) throw_io_error(folder_, "cannot be written to");
  const auto refuse = [&](const Holder& holder, const std::string& advice) {
    ::close(descriptor_);
    const std::string who = holder.pid > 0 ? "process " + std::to_string(holder.pid) + " on " +
                                                 holder.host + " since " + holder.since
                                           : "another process";
    throw InputError(folder_ + ": the folder is in use by " + who + advice);
  };
  struct flock whole {};
  whole.l_type = F_WRLCK;
  const bool locked = ::fcntl(descriptor_, F_OFD_SETLK, &whole) == 0;
  if (!locked && (errno == EAGAIN || errno == EACCES)) {
    refuse(read_holder(descriptor_), "; use another folder with --output, or wait for it");
  }
  if (!held()) return false;
  const Holder before = read_holder(descriptor_);
  const Holder self = this_process();
  if (before.pid > 0 && before.host != self.host) {
    refuse(before, "; if that has died, remove " + path_);
  }
  if (before.pid > 0 && !locked && before.lives()) refuse(before, "");
  const std::string text = self.text();
  if (::ftruncate(descriptor_, 0) != 0 ||
      ::pwrite(descriptor_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size())) {
    const int reason = errno;
    ::unlink(path_.c_str());
    ::close(descriptor_);
    errno = reason;
    throw_io_error(path_, "cannot be written");
  }
  return true;
}

bool FolderLock::held() const {
  struct stat opened {};
  struct stat named {};
  return ::fstat(descriptor_, &opened) == 0 && ::stat(path_.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

FolderLock::~FolderLock() {
  if (held())
    ::unlink(path_.c_str());  // first: who opens it now sees that it is no longer the folder's
  ::close(descriptor_);
}

}  // namespace stylet
