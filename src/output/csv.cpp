#include "stylet/output/csv.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace stylet {

namespace {

constexpr double largest_whole = 9007199254740992.0;  // 2^53: all whole numbers below are exact

}  // namespace

std::string csv_line(std::span<const std::string> fields) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (i > 0) line += ',';
    if (fields[i].find_first_of(",\"\n") == std::string::npos) {
      line += fields[i];
      continue;
    }
    line += '"';
    for (const char c : fields[i]) line.append(c == '"' ? 2 : 1, c);
    line += '"';
  }
  return line + '\n';
}

void append_csv_line(std::string& text, std::span<const double> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) text += ',';
    append_number(text, numbers[i]);
  }
  text += '\n';
}

void append_number(std::string& text, double value) {
  std::array<char, 32> digits;  // the longest double has 24 characters
  const bool whole = std::abs(value) < largest_whole && value == std::trunc(value);
  const auto end = whole
                       ? std::to_chars(digits.begin(), digits.end(), static_cast<long long>(value))
                       : std::to_chars(digits.begin(), digits.end(), value);
  text.append(digits.data(), end.ptr);
}

}  // namespace stylet
