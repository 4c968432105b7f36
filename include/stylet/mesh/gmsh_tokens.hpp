// The words of a Gmsh file with their line numbers, fast enough for millions of elements.
// Errors: InputError "name:line: ...".
#pragma once

#include "stylet/base/errors.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

namespace stylet {

/// Fails with "name:line: message".
[[noreturn]] inline void fail_at(const std::string& name, int line, const std::string& message) {
  throw InputError(name + ":" + std::to_string(line) + ": " + message);
}

/// Refers to name and text, which must outlive it. Lines matter to Gmsh in quoted names only.
class Tokens {
 public:
  Tokens(const std::string& name, std::string_view text) : name_(name), text_(text) {}

  [[noreturn]] void fail(const std::string& message) const { fail_at(name_, line_, message); }
  [[nodiscard]] int line() const { return line_; }

  bool at_end() {
    while (at_ < text_.size() && is_space(text_[at_])) {
      if (text_[at_++] == '\n') ++line_;
    }
    return at_ == text_.size();
  }

  std::string_view word(const char* what) {
    if (at_end()) fail(std::string("the file ends where ") + what + " should be: truncated?");
    const std::size_t from = at_;
    while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
    return text_.substr(from, at_ - from);
  }

  template <class T>
  T number(const char* what) {
    const std::string_view found = word(what);
    T value{};
    const auto [end, status] = std::from_chars(found.data(), found.data() + found.size(), value);
    if (status != std::errc() || end != found.data() + found.size()) {
      fail("expected " + std::string(what) + ", found '" + std::string(found) + "'");
    }
    return value;
  }

  std::int64_t count(const char* what) {
    const auto value = number<std::int64_t>(what);
    if (value < 0) fail(std::string(what) + " is negative: " + std::to_string(value));
    return value;
  }

  void expect(std::string_view closing) {
    const std::string_view found = word(std::string(closing).c_str());
    if (found == closing) return;
    fail("expected " + std::string(closing) + ", found '" + std::string(found) +
         "'; does the count at the head of the section match?");
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
    const int opened = line_;
    const std::string closing = "$End" + std::string(opening.substr(1));
    const std::size_t end = text_.find(closing, at_);
    if (end == std::string_view::npos) {
      fail_at(name_, opened,
              "section " + std::string(opening) + " has no " + closing + ": truncated?");
    }
    line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                                         text_.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
    at_ = end + closing.size();
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

  const std::string& name_;
  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

}  // namespace stylet
