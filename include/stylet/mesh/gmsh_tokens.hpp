// The words and numbers of a Gmsh file, ASCII or binary, with their place in it; fast enough for
// millions of elements.
// Errors: InputError "name:line: ..." or, in a binary file, "name: byte 123: ...".
#pragma once

#include "stylet/base/errors.hpp"
#include "stylet/base/utf8.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace stylet {

/// Where something stands in a file.
struct FilePlace {
  bool is_byte = false;  ///< else a line
  std::int64_t number = 0;
};

[[nodiscard]] inline std::string shown(const std::string& name, FilePlace place) {
  return name + (place.is_byte ? ": byte " : ":") + std::to_string(place.number);
}

[[noreturn]] inline void fail_at(const std::string& name,
                                 FilePlace place,
                                 const std::string& message) {
  throw InputError(shown(name, place) + ": " + message);
}

/// Refers to name and text, which must outlive it. Lines matter to Gmsh in names only.
class Tokens {
 public:
  Tokens(const std::string& name, std::string_view text) : name_(name), text_(text) {}

  /// From here on `integer`, `id` and `real` are binary. id_bytes: 4 in format 2, 8 in format 4.
  void make_binary(int id_bytes) {
    binary_ = true;
    id_bytes_ = id_bytes;
  }
  void swap_bytes() { swapped_ = true; }
  [[nodiscard]] bool binary() const { return binary_; }

  [[nodiscard]] FilePlace place() const {
    return binary_ ? FilePlace{true, static_cast<std::int64_t>(at_)} : FilePlace{false, line_};
  }
  [[noreturn]] void fail(const std::string& message) const { fail_at(name_, place(), message); }

  // Text, also in binary files.

  bool at_end() {
    while (at_ < text_.size() && is_space(text_[at_])) {
      if (text_[at_++] == '\n') ++line_;
    }
    return at_ == text_.size();
  }

  std::string_view word(const char* what) {
    if (at_end()) fail_as_truncated(what);
    const std::size_t from = at_;
    while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
    return text_.substr(from, at_ - from);
  }

  template <class T>
  T number(const char* what) {
    const std::string_view found = word(what);
    // from_chars knows no plus sign.
    const std::string_view digits = found.size() > 1 && found[0] == '+' ? found.substr(1) : found;
    T value{};
    const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (status != std::errc() || end != digits.data() + digits.size()) {
      fail("expected " + std::string(what) + ", found '" + cut_short(found, 40) + "'");
    }
    return value;
  }

  std::int64_t count(const char* what) { return not_negative(number<std::int64_t>(what), what); }

  void expect(std::string_view closing) {
    const std::string_view found = word(std::string(closing).c_str());
    if (found == closing) return;
    fail("expected " + std::string(closing) + ", found '" + cut_short(found, 40) +
         "'; does the count at the head of the section match?");
  }

  /// The end of the line up to which a section is text; binary numbers follow it at once.
  void end_line() {
    const std::size_t end = text_.find('\n', at_);
    if (end == std::string_view::npos) fail_as_truncated("the end of a line");
    at_ = end + 1;
    ++line_;
  }

  /// The rest of this line before its first quote, without spaces around it.
  std::string_view before_quote() {
    std::string_view rest = text_.substr(at_, text_.find('\n', at_) - at_);
    rest = rest.substr(0, rest.find('"'));
    while (!rest.empty() && is_space(rest.front())) rest.remove_prefix(1);
    while (!rest.empty() && is_space(rest.back())) rest.remove_suffix(1);
    return rest;
  }

  /// The text between the first and the last quote of this line.
  std::string quoted() {
    const std::string_view rest = text_.substr(at_, text_.find('\n', at_) - at_);
    const std::size_t first = rest.find('"');
    const std::size_t last = rest.rfind('"');
    if (first == last) fail("expected a name in double quotes");
    at_ += last + 1;
    return std::string(rest.substr(first + 1, last - first - 1));
  }

  void skip_section(std::string_view opening) {
    const FilePlace opened = place();
    const std::string closing = "$End" + std::string(opening.substr(1));
    const std::size_t end = text_.find(closing, at_);
    if (end == std::string_view::npos) {
      fail_at(name_, opened,
              "section " + cut_short(opening, 40) + " has no " + cut_short(closing, 40) +
                  ": truncated?");
    }
    line_ += std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                        text_.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    at_ = end + closing.size();
  }

  // Text or binary, as the file is.

  int integer(const char* what) { return binary_ ? raw<std::int32_t>(what) : number<int>(what); }

  /// A count, or the number of a node or an element.
  std::int64_t id(const char* what) {
    if (!binary_) return count(what);
    return not_negative(id_bytes_ == 4 ? raw<std::int32_t>(what) : raw<std::int64_t>(what), what);
  }

  double real(const char* what) {
    const double value = binary_ ? raw<double>(what) : number<double>(what);
    if (!std::isfinite(value))
      fail("expected " + std::string(what) + ", found a number not finite");
    return value;
  }

  template <class T>
  T raw(const char* what) {
    if (text_.size() - at_ < sizeof(T)) fail_as_truncated(what);
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), text_.data() + at_, sizeof(T));
    if (swapped_) std::ranges::reverse(bytes);
    at_ += sizeof(T);
    T value;
    std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

  [[noreturn]] void fail_as_truncated(const char* what) const {
    fail(std::string("the file ends where ") + what + " should be: truncated?");
  }

  std::int64_t not_negative(std::int64_t value, const char* what) const {
    if (value < 0) fail(std::string(what) + " is negative: " + std::to_string(value));
    return value;
  }

  const std::string& name_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::int64_t line_ = 1;
  bool binary_ = false;
  bool swapped_ = false;
  int id_bytes_ = 8;
};

}  // namespace stylet
