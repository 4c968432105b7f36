// A file written through the operating system's own calls, because streams hide why a write failed.
#pragma once

#include <string>
#include <string_view>

namespace stylet {

/// Created or emptied when opened, unless it is opened to append. Every failure throws an IoError with path and reason.
/// Not collective: one rank owns it.
class TextFile {
 public:
  enum class Open { anew, append };
  explicit TextFile(std::string path, Open how = Open::anew);
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  ~TextFile();

  /// Hands all bytes to the operating system: they survive the death of this program.
  void write(std::string_view text);
  /// Waits for the disk: some file systems tell only here that they are full.
  void sync();
  void close();

 private:
  std::string path_;
  int descriptor_;
};

/// IoError with the text of `errno`.
[[noreturn]] void throw_io_error(const std::string& path, const std::string& what);

}  // namespace stylet
