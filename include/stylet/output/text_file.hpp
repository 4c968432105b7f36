// A file written through the operating system's own calls, because streams hide why a write failed.
#pragma once

#include <string>
#include <string_view>

namespace stylet {

/// Where a file stands while it is made: in the same folder, under a name that nobody else uses.
[[nodiscard]] std::string draft_of(const std::string& path);

/// Every failure throws an IoError with path and reason. Not collective: one rank owns it.
class TextFile {
 public:
  /// draft: a new file that is at `path` from `appear` on, and is removed without it.
  enum class Open { draft, append };
  explicit TextFile(std::string path, Open how = Open::draft);
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  ~TextFile();

  /// Hands all bytes to the operating system: they survive the death of this program.
  void write(std::string_view text);
  /// Takes the name `path`, in one moment, with what is written so far.
  void appear();
  /// Waits for the disk: some file systems tell only here that they are full.
  void sync();
  void close();

 private:
  std::string path_;
  std::string draft_;  ///< empty once it appeared
  int descriptor_;
};

/// Waits until the disk has the name of a file, after it appeared.
void sync_folder(const std::string& path);

/// IoError with the text of `errno`.
[[noreturn]] void throw_io_error(const std::string& path, const std::string& what);

}  // namespace stylet
