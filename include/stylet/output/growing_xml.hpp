// An XML file that grows before its last tags, and is well-formed at every moment.
//
// Before the last tags stands a processing instruction with room in it, <?room ... ?>, which readers pass
// over. What is new is written into the room, with the opening of the room that is left behind it; then
// the old opening is overwritten by spaces, which are few bytes of one page: a killed program has
// done that or has not. So a file costs what is added to it, and not as often a new file.
#pragma once

#include <string>
#include <string_view>
#include <sys/types.h>

namespace stylet {

/// Every failure throws an IoError. Not collective: one rank owns it.
class GrowingXml {
 public:
  /// Writes a file without content; replaces an old one.
  GrowingXml(std::string path, std::string first, std::string last);
  GrowingXml(const GrowingXml&) = delete;
  GrowingXml& operator=(const GrowingXml&) = delete;
  ~GrowingXml();

  /// Whole elements, without processing instructions.
  void append(std::string_view text);
  /// All but the last tags.
  [[nodiscard]] const std::string& text() const { return text_; }
  /// Takes the room out.
  void finish();

 private:
  void rewrite(std::size_t room);
  void put(std::string_view text, off_t at);

  std::string path_;
  std::string text_;  ///< all but the last tags
  std::string last_;
  int descriptor_ = -1;
  off_t opening_ = 0;
  off_t closing_ = 0;  ///< of the room
};

}  // namespace stylet
