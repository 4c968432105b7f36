#include "stylet/output/text_file.hpp"

#include "stylet/base/errors.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace stylet {

void throw_io_error(const std::string& path, const std::string& what) {
  const int number = errno;
  throw IoError(path + ": " + what + ": " + std::strerror(number));
}

TextFile::TextFile(std::string path, Open how)
    : path_(std::move(path)),
      descriptor_(
          ::open(path_.c_str(),
                 O_WRONLY | O_CREAT | O_CLOEXEC | (how == Open::append ? O_APPEND : O_TRUNC),
                 0666)) {
  if (descriptor_ < 0) throw_io_error(path_, "cannot be created");
}

TextFile::~TextFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
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
