// One process at a time works in a folder.
#pragma once

#include <string>

namespace stylet {

/// A file with the holder's name, and a lock of the operating system on it, which ends with the
/// process. Where the file system cannot lock (some network file systems), or the holder was on
/// another machine, the name alone decides. Not collective.
class FolderLock {
 public:
  /// Throws an InputError that says who works in the folder, an IoError if it cannot be written to.
  explicit FolderLock(const std::string& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

  [[nodiscard]] const std::string& path() const { return path_; }
  /// False if its file was removed or replaced since: the folder is gone, or another's.
  [[nodiscard]] bool held() const;

  static constexpr const char* file_name = ".stylet.lock";

 private:
  /// False if another process removed the file meanwhile.
  bool take();

  std::string folder_;
  std::string path_;
  int descriptor_ = -1;
};

}  // namespace stylet
