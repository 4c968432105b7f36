#include "stylet/output/status_file.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/output/text_file.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array stops{SIGTERM, SIGINT, SIGHUP, SIGQUIT, SIGXCPU, SIGUSR1};
constexpr std::array crashes{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
constexpr off_t room = 32 * 1024;  // bytes kept for the last text

/// What a signal handler needs, all of it made before; handlers can be told nothing else.
struct LastWords {
  volatile std::sig_atomic_t descriptor = -1;  ///< of the room on the disk; -1: none, or used
  std::string reserve;                         ///< its name
  std::string path;
  std::string lock;
  std::array<std::string, NSIG> texts;
  pid_t first = 0;    ///< rank 0, where it is another process of this machine
  std::string draft;  ///< of what is said when that has died
  std::string orphaned;
  volatile std::sig_atomic_t signal = 0;
  OnSignal on_signal = OnSignal::tell;
};

LastWords& words() {
  static LastWords the;
  return the;
}

/// Only calls that POSIX allows in a handler. Whether the text took the summary's name.
bool speak(const std::string& text) {
  LastWords& last = words();
  const int descriptor = last.descriptor;
  last.descriptor = -1;
  if (descriptor < 0) return false;
  const auto size = static_cast<ssize_t>(text.size());
  const bool written = ::pwrite(descriptor, text.data(), text.size(), 0) == size &&
                       ::ftruncate(descriptor, size) == 0 && ::fsync(descriptor) == 0 &&
                       ::rename(last.reserve.c_str(), last.path.c_str()) == 0;
  ::close(descriptor);
  return written;
}

/// Only calls that POSIX allows in a handler.
void speak_for_first() {
  const LastWords& last = words();
  if (last.first == 0 || ::kill(last.first, 0) == 0 || errno != ESRCH) return;
  const int descriptor = ::open(last.draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) return;
  const auto size = static_cast<ssize_t>(last.orphaned.size());
  const bool written = ::write(descriptor, last.orphaned.data(), last.orphaned.size()) == size &&
                       ::fsync(descriptor) == 0;
  ::close(descriptor);
  if (!written || ::rename(last.draft.c_str(), last.path.c_str()) != 0) {
    ::unlink(last.draft.c_str());
  }
}

void on_stop(int signal) {
  const int before = errno;
  LastWords& last = words();
  (void)speak(last.texts[static_cast<std::size_t>(signal)]);
  speak_for_first();
  last.signal = signal;
  if (last.on_signal == OnSignal::end) {
    if (!last.lock.empty()) ::unlink(last.lock.c_str());
    ::_exit(128 + signal);
  }
  errno = before;
}

void on_crash(int signal) {
  (void)speak(words().texts[static_cast<std::size_t>(signal)]);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// An ignored signal (nohup, a job in the background) stays ignored. After the first one the next
/// of its kind has its usual effect: it ends a process that hangs.
void handle(int signal, void (*handler)(int)) {
  struct sigaction action {};
  ::sigaction(signal, nullptr, &action);
  if (action.sa_handler == SIG_IGN) return;
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
  ::sigaction(signal, &action, nullptr);
}

void unhandle(int signal, void (*handler)(int)) {
  struct sigaction action {};
  ::sigaction(signal, nullptr, &action);
  if (action.sa_handler == handler) std::signal(signal, SIG_DFL);
}

/// No signal is handled while the last text is written.
class SignalsWait {
 public:
  SignalsWait() {
    sigset_t wait;
    ::sigemptyset(&wait);
    for (const int signal : stops) ::sigaddset(&wait, signal);
    ::sigprocmask(SIG_BLOCK, &wait, &before_);
  }
  SignalsWait(const SignalsWait&) = delete;
  SignalsWait& operator=(const SignalsWait&) = delete;
  ~SignalsWait() { ::sigprocmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_{};
};

std::string in_short(const std::string& status, const std::string& error) {
  return summary_text({{"status", status}, {"error", error}});
}

/// Collective. The process of rank 0, on the others if they are on its machine.
pid_t first_of(MPI_Comm comm) {
  struct Place {
    long pid = ::getpid();
    std::array<char, 256> host{};
  };
  Place here;
  if (::gethostname(here.host.data(), here.host.size() - 1) != 0) here.host[0] = '\0';
  Place first = here;
  MPI_Bcast(&first, sizeof first, MPI_BYTE, 0, comm);
  return rank_of(comm) != 0 && first.host == here.host ? static_cast<pid_t>(first.pid) : 0;
}

void take_room() {
  LastWords& last = words();
  ::unlink(last.reserve.c_str());
  const int descriptor =
      ::open(last.reserve.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) throw_io_error(last.path, "cannot be created");
  if (const int reason = ::posix_fallocate(descriptor, 0, room); reason != 0) {
    ::close(descriptor);
    ::unlink(last.reserve.c_str());
    errno = reason;
    throw_io_error(last.path, "cannot be written");
  }
  last.descriptor = descriptor;
}

}  // namespace

std::string with_next_step(const std::string& message) {
  return message + "; when it can be written again, go on with --resume";
}

StatusFile::StatusFile(MPI_Comm comm, std::string path, OnSignal on_signal, std::string lock)
    : comm_(comm), path_(std::move(path)) {
  LastWords& last = words();
  last.path = path_;
  last.reserve = path_.substr(0, path_.find_last_of('/') + 1) + ".stylet.reserve";
  last.lock = rank_of(comm) == 0 ? std::move(lock) : std::string();
  last.on_signal = on_signal;
  last.signal = 0;
  last.first = first_of(comm);
  last.draft = draft_of(path_ + "." + std::to_string(rank_of(comm)));
  last.orphaned = in_short("failed", "the process of rank 0 has died");
  for (const int s : stops) {
    last.texts[static_cast<std::size_t>(s)] =
        in_short("stopped", std::string("stopped by signal ") + ::sigabbrev_np(s));
  }
  for (const int s : crashes) {
    last.texts[static_cast<std::size_t>(s)] =
        in_short("failed", std::string("crashed with signal ") + ::sigabbrev_np(s));
  }
  agree_after(comm, [&] {
    if (rank_of(comm) == 0) take_room();
  });
  for (const int s : stops) handle(s, on_stop);
  for (const int s : crashes) handle(s, on_crash);
}

StatusFile::~StatusFile() {
  for (const int s : stops) unhandle(s, on_stop);
  for (const int s : crashes) unhandle(s, on_crash);
  LastWords& last = words();
  const int descriptor = last.descriptor;
  last.descriptor = -1;
  if (descriptor >= 0) ::close(descriptor);
  if (rank_of(comm_) == 0) ::unlink(last.reserve.c_str());
}

void StatusFile::abandon() {
  finished_ = true;
  LastWords& last = words();
  const int descriptor = last.descriptor;
  last.descriptor = -1;
  if (descriptor >= 0) ::close(descriptor);
  last.reserve.clear();
}

void StatusFile::finish(const Json& summary) {
  if (finished_) return;
  finished_ = true;
  const SignalsWait wait;
  if (rank_of(comm_) == 0) {
    write_last(summary);
    return;
  }
  ::unlink(words().reserve.c_str());  // what rank 0 says when it is ended counts no more
  TextFile file(path_);
  file.write(summary_text(summary));
  file.close();
  file.appear();
}

void StatusFile::write_last(const Json& summary) {
  const std::string text = summary_text(summary);
  if (static_cast<off_t>(text.size()) <= room && speak(text)) return;
  try {
    TextFile file(path_);
    file.write(text);
    file.sync();
    file.close();
    file.appear();
  } catch (const Error&) {
    const auto status = summary.at("status").get<std::string>();
    (void)speak(in_short(status, summary.value("error", "the whole summary could not be written")));
    throw;
  }
}

void StatusFile::fail_at_once(const std::string& error) {
  std::fprintf(stderr, "\nstylet: %s\n", error.c_str());
  (void)speak(in_short("failed", error));
}

int StatusFile::signal() {
  return words().signal;
}

}  // namespace stylet
