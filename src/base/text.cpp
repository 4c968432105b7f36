#include "stylet/base/text.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/utf8.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace stylet {

std::size_t edit_distance(const std::string& a, const std::string& b) {
  // One row of the distance table at a time: row[j] belongs to the first j characters of b.
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::string nearest(const std::string& word, std::span<const std::string> candidates) {
  const auto best = std::ranges::min_element(candidates, {}, [&word](const std::string& candidate) {
    return edit_distance(word, candidate);
  });
  return best == candidates.end() ? std::string() : *best;
}

std::string join(std::span<const std::string> words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += separator;
    text += word;
  }
  return text;
}

std::string exact(double value) {
  std::array<char, 32> buffer{};  // a double needs at most 24 characters
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), end};
}

std::string ten_digits(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.10g", value);
  return text.data();
}

double cleared(double value, double size) {
  constexpr double round_off = 1e-12;
  return std::abs(value) <= round_off * size ? 0 : value;
}

Path parse_path(std::string_view text, char end) {
  Path path;
  const auto at_end = [&] {
    return path.length == text.size() || (end != '\0' && text[path.length] == end);
  };
  while (!at_end() || !path.names.empty()) {
    std::string& name = path.names.emplace_back();
    if (path.length < text.size() && text[path.length] == '"') {
      std::size_t i = path.length + 1;
      for (; i < text.size() && text[i] != '"'; ++i) {
        if (text[i] == '\\' && i + 1 < text.size()) ++i;
        name += text[i];
      }
      if (i >= text.size()) {
        throw InputError("'" + cut_short(text, 80) + "': a name in quotes has no closing quote");
      }
      path.length = i + 1;
    }
    for (; !at_end() && text[path.length] != '.'; ++path.length) name += text[path.length];
    if (at_end()) break;
    ++path.length;  // the dot
  }
  return path;
}

std::string below(const std::string& path, const std::string& name) {
  std::string part = name;
  if (name.empty() || name.find_first_of(".\"\\=") != std::string::npos) {
    part = "\"";
    for (const char c : name) part += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
    part += "\"";
  }
  return path.empty() ? part : path + "." + part;
}

std::string plain_path(std::string_view text) {
  std::string path;
  for (const auto& name : parse_path(text).names) path = below(path, name);
  return path;
}

}  // namespace stylet
