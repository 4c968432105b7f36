// Small text helpers for messages.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace stylet {

/// Number of inserted, removed or replaced characters that turn `a` into `b`.
[[nodiscard]] std::size_t edit_distance(const std::string& a, const std::string& b);

/// The candidate with the smallest edit distance to `word`, the first one of equals; empty if there
/// is no candidate.
[[nodiscard]] std::string nearest(const std::string& word, std::span<const std::string> candidates);

/// "a, b, c".
[[nodiscard]] std::string join(std::span<const std::string> words,
                               const std::string& separator = ", ");

/// The shortest decimal (at most 17 significant digits) that reads back as exactly `value`.
[[nodiscard]] std::string exact(double value);

/// Ten digits, for coordinates in messages: what round-off has left alone, and enough to tell a point
/// from the boundary beside it.
[[nodiscard]] std::string ten_digits(double value);

/// `value`, or zero where it is round-off beside `size`: what turning a point or subtracting lengths of
/// that size leaves of nothing.
[[nodiscard]] double cleared(double value, double size);

/// A path such as needles.0.height: names joined by dots. A name that would be taken apart, such as
/// lobe.left, stands in it in double quotes.
struct Path {
  std::vector<std::string> names;
  std::size_t length = 0;  ///< of the text read: up to `end` or all of it
};

/// Throws InputError where a quote is not closed.
[[nodiscard]] Path parse_path(std::string_view text, char end = '\0');

/// The path of `name` below `path`.
[[nodiscard]] std::string below(const std::string& path, const std::string& name);

/// The same path with quotes only where they are needed.
[[nodiscard]] std::string plain_path(std::string_view text);

}  // namespace stylet
