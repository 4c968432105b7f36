// Finds out that a disk is full before a parallel library meets it.
#pragma once

#include <cstdint>
#include <string>
#include <sys/types.h>

namespace stylet {

/// Room behind the end of an existing file, which keeps its size. Not collective.
class DiskReserve {
 public:
  explicit DiskReserve(std::string path);
  /// Throws an IoError unless so many bytes more can be written. File systems that cannot reserve are
  /// asked for their free space instead.
  void require(std::uint64_t bytes);
  /// Gives back what was not used.
  void free();

 private:
  int reserve(int descriptor, off_t bytes);

  std::string path_;
  off_t end_ = 0;  ///< of what is reserved
};

/// Throws an IoError in the name of `path` unless a file `draft` of so many bytes can be made; removes
/// it again. Not collective.
void require_room(const std::string& draft, const std::string& path, std::uint64_t bytes);

}  // namespace stylet
