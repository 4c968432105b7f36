#include "stylet/base/utf8.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace stylet {

namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

constexpr std::array<std::pair<char32_t, const char*>, 12> names = {{
    {0x00, "null character"},
    {0xA0, "non-breaking space"},
    {0xAD, "soft hyphen"},
    {0x2009, "thin space"},
    {0x200B, "zero-width space"},
    {0x200C, "zero-width non-joiner"},
    {0x200D, "zero-width joiner"},
    {0x200E, "left-to-right mark"},
    {0x200F, "right-to-left mark"},
    {0x202F, "narrow non-breaking space"},
    {0x2060, "word joiner"},
    {0xFEFF, "byte order mark"},
}};

bool between(char32_t code, char32_t first, char32_t last) {
  return code >= first && code <= last;
}

std::string hexadecimal(const char* format, char32_t code) {
  char text[24];
  std::snprintf(text, sizeof text, format, static_cast<unsigned>(code));
  return text;
}

bool is_hidden(const Glyph& glyph) {
  return !glyph.valid || is_control(glyph.code) || is_invisible(glyph.code) ||
         is_typographic_space(glyph.code);
}

}  // namespace

Glyph first_glyph(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text[0]);
  const Glyph fault{lead, 1, false};
  if (lead < 0x80) return {lead, 1, true};
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return fault;
  char32_t code = lead & (0x7FU >> length);
  for (const char c : text.substr(1, length - 1)) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0U) != 0x80U) return fault;
    code = (code << 6U) | (byte & 0x3FU);
  }
  constexpr std::array<char32_t, 5> least = {0, 0, 0x80, 0x800, 0x10000};
  if (code < least[length] || code > 0x10FFFF || between(code, 0xD800, 0xDFFF)) return fault;
  return {code, length, true};
}

bool is_control(char32_t code) {
  if (code == '\t' || code == '\n' || code == '\r') return false;
  return code < 0x20 || between(code, 0x7F, 0x9F);
}

bool is_invisible(char32_t code) {
  return code == 0xAD || code == 0x61C || code == 0x180E || between(code, 0x200B, 0x200F) ||
         between(code, 0x2028, 0x202E) || between(code, 0x2060, 0x2069) || code == 0xFEFF;
}

bool is_typographic_space(char32_t code) {
  return code == 0xA0 || code == 0x1680 || between(code, 0x2000, 0x200A) || code == 0x202F ||
         code == 0x205F || code == 0x3000;
}

std::string named(const Glyph& glyph) {
  if (!glyph.valid) return hexadecimal("byte 0x%02X", glyph.code);
  const auto* known = std::ranges::find(names, glyph.code, &decltype(names)::value_type::first);
  const std::string code = hexadecimal("U+%04X", glyph.code);
  return known == names.end() ? code : code + " (" + known->second + ")";
}

std::string visible(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const Glyph glyph = first_glyph(text);
    if (is_hidden(glyph)) {
      shown += hexadecimal(glyph.valid ? "<U+%04X>" : "<0x%02X>", glyph.code);
    } else {
      shown += text.substr(0, glyph.length);
    }
    text.remove_prefix(glyph.length);
  }
  return shown;
}

std::string cut_short(std::string_view text, std::size_t longest) {
  if (text.size() <= longest) return visible(text);
  std::size_t end = longest;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return visible(text.substr(0, end)) + "...";
}

std::optional<TextFault> fault_of_text(std::string_view text) {
  TextFault fault;
  while (!text.empty()) {
    const Glyph glyph = first_glyph(text);
    if (!glyph.valid) {
      fault.what = named(glyph) + " is not UTF-8; save the file as UTF-8";
      return fault;
    }
    if (is_control(glyph.code)) {
      fault.what = "control character " + named(glyph);
      return fault;
    }
    ++fault.column;
    if (glyph.code == '\n') {
      ++fault.line;
      fault.column = 1;
    }
    text.remove_prefix(glyph.length);
  }
  return std::nullopt;
}

std::string_view without_byte_order_mark(std::string_view text) {
  return text.starts_with(byte_order_mark) ? text.substr(byte_order_mark.size()) : text;
}

}  // namespace stylet
