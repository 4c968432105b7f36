// Sets of small numbers as sorted vectors.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace stylet {

/// Sorts and drops repetitions.
template <class T>
void sort_unique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// Place of a value in ascending ones that have it.
inline std::size_t position(std::span<const int> ascending, int value) {
  return static_cast<std::size_t>(std::ranges::lower_bound(ascending, value) - ascending.begin());
}

}  // namespace stylet
