// Characters that a reader of a message would not see, and bytes that are no UTF-8 at all.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace stylet {

struct Glyph {
  char32_t code = 0;
  std::size_t length = 1;  ///< bytes
  bool valid = true;       ///< false: one byte that is no UTF-8
};

/// The character at the start of `text`, which is not empty.
[[nodiscard]] Glyph first_glyph(std::string_view text);

/// Control characters other than tab and line ends.
[[nodiscard]] bool is_control(char32_t code);
/// What takes no room on a line: zero-width spaces and joiners, soft hyphens, marks of direction and
/// of byte order.
[[nodiscard]] bool is_invisible(char32_t code);
/// Spaces that YAML and units do not take for one, such as the non-breaking space.
[[nodiscard]] bool is_typographic_space(char32_t code);

/// 'U+00A0 (non-breaking space)', or 'byte 0xE9'.
[[nodiscard]] std::string named(const Glyph& glyph);

/// With <U+00A0> for what could not be seen, and for bytes that are no UTF-8.
[[nodiscard]] std::string visible(std::string_view text);

/// At most about so many bytes of it, visible, with '...' where it was cut.
[[nodiscard]] std::string cut_short(std::string_view text, std::size_t longest);

struct TextFault {
  int line = 1;
  int column = 1;  ///< in characters
  std::string what;
};

/// The first byte that is no UTF-8, or control character.
[[nodiscard]] std::optional<TextFault> fault_of_text(std::string_view text);

/// Without the mark of byte order that some editors put before UTF-8.
[[nodiscard]] std::string_view without_byte_order_mark(std::string_view text);

}  // namespace stylet
