// Which rows of an array a rank writes.
#pragma once

#include <algorithm>

namespace stylet {

/// Half-open range of rows.
struct Range {
  int begin = 0;
  int end = 0;
  [[nodiscard]] int size() const { return end - begin; }
};

/// The rows that a rank writes: consecutive, and of equal number up to one.
[[nodiscard]] inline Range chunk(int n, int rank, int n_ranks) {
  const int share = n / n_ranks;
  const int rest = n % n_ranks;
  const int begin = rank * share + std::min(rank, rest);
  return {begin, begin + share + (rank < rest ? 1 : 0)};
}

}  // namespace stylet
