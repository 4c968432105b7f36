// Lines of CSV (RFC 4180), for every file of rows that is written.
#pragma once

#include <span>
#include <string>

namespace stylet {

/// One line; a field with commas, quotes or line ends is quoted.
[[nodiscard]] std::string csv_line(std::span<const std::string> fields);
/// The same of numbers.
void append_csv_line(std::string& text, std::span<const double> numbers);

/// Appends the shortest text that reads back to the same bits; whole numbers have no exponent.
void append_number(std::string& text, double value);

}  // namespace stylet
