// The folder that a verb writes to, and text files that are either whole or absent.
#pragma once

#include "stylet/output/folder_lock.hpp"
#include "stylet/output/manifest.hpp"
#include "stylet/output/status_file.hpp"

#include <mpi.h>
#include <nlohmann/json_fwd.hpp>

#include <chrono>
#include <exception>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

/// What is to become of earlier results in a folder.
enum class Earlier { refuse, replace, keep };

/// What a verb puts into its folder, beside summary.json.
struct Contents {
  std::string what;                ///< the verb
  std::vector<std::string> names;  ///< of files; folders of numbered files end with /
  std::vector<std::string> grows;  ///< those of them that may have changed when they are kept
};

/// Replaces and removes only what this program wrote (manifest.hpp), and is locked while it lives.
/// summary.json says what became of the work, also after a signal or an exception.
class OutputFolder {
 public:
  /// Collective. Creates the folder, its parents and the folders in it. Throws InputError if it is
  /// in use, holds anything that is not ours under a name that is to be written, holds results and
  /// `earlier` is refuse, or holds anything and is not marked as ours.
  OutputFolder(MPI_Comm comm, std::string path, Contents contents, Earlier earlier, OnSignal);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

  [[nodiscard]] const std::string& path() const { return path_; }

  /// Not collective; for rank 0. Whether it was removed, or has become another's, as far as is known: it is
  /// looked at once a second.
  [[nodiscard]] bool is_lost();
  /// Collective. A folder of numbered files in it that is needed after all; its name ends with /. Throws
  /// InputError if something else stands there.
  void add(const std::string& name);
  /// Collective. The summary while the work goes on; without one it says just that.
  void go_on();
  void go_on(const nlohmann::ordered_json& summary);
  /// Collective. The last summary. Folders in it that are empty go.
  void finish(const nlohmann::ordered_json& summary);
  /// Not collective, and for any rank: waits a moment for the others, so that one text is written.
  /// Takes what is known so far, if anything, and adds status and error.
  void fail(const std::exception& error) noexcept;
  void fail(const std::exception& error, nlohmann::ordered_json summary) noexcept;

 private:
  void prepare(Earlier earlier);
  void remove_own();

  MPI_Comm comm_;
  std::string path_;
  Contents contents_;
  // Of rank 0.
  std::optional<FolderLock> lock_;
  std::optional<Manifest> manifest_;
  std::optional<StatusFile> status_;
  bool is_lost_ = false;
  std::chrono::steady_clock::time_point looked_ = {};
};

/// Runs `body`; what it throws is told in the folder's summary and thrown on.
template <class Body>
void in_folder(OutputFolder& folder, Body&& body) {
  try {
    body();
  } catch (const std::exception& error) {
    folder.fail(error);
    throw;
  }
}

/// Collective. Marks a folder that is to hold folders of ours; creates it where there is none.
/// Throws InputError if it holds anything and is not marked.
void mark_parent(MPI_Comm comm, const std::string& path);

/// yes: survives a power failure, at the price of waiting for the disk. no: survives the death of
/// the program.
enum class Durable { yes, no };

/// Collective. Rank 0 writes `text` beside `path` and renames it, so that a killed run or a full disk
/// leaves the old file. `text` of the other ranks is not used. All ranks throw exit code `io`.
void write_text_atomically(MPI_Comm comm,
                           const std::string& path,
                           const std::string& text,
                           Durable durable = Durable::yes);

}  // namespace stylet
