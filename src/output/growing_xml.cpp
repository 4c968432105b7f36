#include "stylet/output/growing_xml.hpp"

#include "stylet/output/text_file.hpp"

#include <algorithm>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace stylet {

namespace {

constexpr std::string_view opening = "<?room ";
constexpr std::string_view closing = "?>\n";

// Spaces before an opening that would lie on two pages.
std::size_t padding(off_t at) {
  constexpr std::size_t page = 4096;
  const std::size_t left = page - static_cast<std::size_t>(at) % page;
  return left < opening.size() ? left : 0;
}

}  // namespace

GrowingXml::GrowingXml(std::string path, std::string first, std::string last)
    : path_(std::move(path)), text_(std::move(first)), last_(std::move(last)) {
  rewrite(0);
}

GrowingXml::~GrowingXml() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void GrowingXml::rewrite(std::size_t room) {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  TextFile file(path_);
  file.write(text_);
  if (room > 0) {
    const std::size_t before = padding(static_cast<off_t>(text_.size()));
    opening_ = static_cast<off_t>(text_.size() + before);
    closing_ = opening_ + static_cast<off_t>(opening.size() + room);
    file.write(std::string(before, ' ') + std::string(opening) + std::string(room, ' ') +
               std::string(closing));
  }
  file.write(last_);
  file.close();
  file.appear();
  if (room == 0) return;
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor_ < 0) throw_io_error(path_, "cannot be opened");
}

void GrowingXml::append(std::string_view text) {
  text_ += text;
  const off_t at = opening_ + static_cast<off_t>(opening.size());
  const off_t end = at + static_cast<off_t>(text.size());
  const std::size_t before = padding(end);
  const off_t next = end + static_cast<off_t>(before);
  if (descriptor_ < 0 || next + static_cast<off_t>(opening.size()) > closing_) {
    constexpr std::size_t least = 1 << 15;
    rewrite(std::max(least, text_.size()));
    return;
  }
  put(std::string(text) + std::string(before, ' ') + std::string(opening), at);
  put(std::string(opening.size(), ' '), opening_);
  opening_ = next;
}

void GrowingXml::put(std::string_view text, off_t at) {
  if (::pwrite(descriptor_, text.data(), text.size(), at) != static_cast<ssize_t>(text.size())) {
    throw_io_error(path_, "cannot be written");
  }
}

void GrowingXml::finish() {
  rewrite(0);
}

}  // namespace stylet
