#include "stylet/output/text_file.hpp"

#include "stylet/base/errors.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace stylet {

void throw_io_error(const std::string& path, const std::string& what) {
  const int number = errno;
  throw IoError(path + ": " + what + ": " + std::strerror(number));
}

std::string draft_of(const std::string& path) {
  const auto name = path.find_last_of('/') + 1;  // 0 without a folder
  return path.substr(0, name) + ".stylet." + path.substr(name) + ".tmp";
}

void sync_folder(const std::string& path) {
  const auto slash = path.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw_io_error(folder, "cannot be opened");
  const int failed = ::fsync(descriptor);
  ::close(descriptor);
  if (failed != 0 && errno != EINVAL && errno != EROFS) throw_io_error(folder, "cannot be written");
}

TextFile::TextFile(std::string path, Open how)
    : path_(std::move(path)), draft_(how == Open::draft ? draft_of(path_) : "") {
  if (draft_.empty()) {
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC | O_NOFOLLOW);
  } else {
    ::unlink(draft_.c_str());  // of a run that was killed
    descriptor_ = ::open(draft_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  }
  if (descriptor_ < 0) throw_io_error(path_, "cannot be created");
}

TextFile::~TextFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!draft_.empty()) ::unlink(draft_.c_str());
}

void TextFile::appear() {
  if (std::rename(draft_.c_str(), path_.c_str()) != 0) throw_io_error(path_, "cannot be replaced");
  draft_.clear();
}

void TextFile::write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor_, text.data(), text.size());
    if (written >= 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      throw_io_error(path_, "cannot be written");
    }
  }
}

void TextFile::sync() {
  // Pipes and devices cannot be synchronised, which is no failure.
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != EROFS) {
    throw_io_error(path_, "cannot be written");
  }
}

void TextFile::close() {
  const int descriptor = std::exchange(descriptor_, -1);
  if (descriptor >= 0 && ::close(descriptor) != 0) throw_io_error(path_, "cannot be written");
}

}  // namespace stylet
