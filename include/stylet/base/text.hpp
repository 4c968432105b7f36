// Small text helpers for messages.
#pragma once

#include <cstddef>
#include <span>
#include <string>
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

}  // namespace stylet
