// summary.json, whose `status` is true after every way out: running, completed, failed, stopped.
#pragma once

#include <mpi.h>
#include <nlohmann/json_fwd.hpp>

#include <string>

namespace stylet {

/// Of a file that cannot be written, with what to do next.
[[nodiscard]] std::string with_next_step(const std::string& message);

/// What TERM, INT and HUP do: are told by `signal`, or end the process.
enum class OnSignal { tell, end };

/// Room for the last text is taken when the file is begun, so that a full disk cannot keep it from
/// being written; signals, crashes included, write a short one (signals that were ignored when the
/// program started stay ignored). Where rank 0 has died, the others do so for it, if they are on its
/// machine. One object at a time.
class StatusFile {
 public:
  /// Collective. `lock` is removed when a signal ends the process.
  StatusFile(MPI_Comm comm, std::string path, OnSignal on_signal, std::string lock);
  StatusFile(const StatusFile&) = delete;
  StatusFile& operator=(const StatusFile&) = delete;
  ~StatusFile();

  /// Not collective. The last text; only the first call counts. Of ranks other than 0 only one
  /// that the others have left alone may call it. Throws an IoError if it was written in short only.
  void finish(const nlohmann::ordered_json& summary);

  /// Not collective. The file is another's by now: nothing is written or removed any more.
  void abandon();

  /// Not collective. For rank 0 when it is about to abort the job; on stderr too.
  static void fail_at_once(const std::string& error);

  /// The signal that asked this rank to stop; 0: none.
  [[nodiscard]] static int signal();

 private:
  void write_last(const nlohmann::ordered_json& summary);

  MPI_Comm comm_;
  std::string path_;
  bool finished_ = false;
};

}  // namespace stylet
