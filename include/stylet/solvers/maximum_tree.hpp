// The largest of many values, of which few change at a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace stylet {

class MaximumTree {
 public:
  /// All zero.
  explicit MaximumTree(std::size_t n = 0) : n_(n), tree_(2 * std::max<std::size_t>(n, 1), 0.0) {}
  /// In log n operations.
  void set(std::size_t i, double value) {
    std::size_t at = n_ + i;
    tree_[at] = value;
    for (at /= 2; at >= 1; at /= 2) tree_[at] = std::max(tree_[2 * at], tree_[2 * at + 1]);
  }
  [[nodiscard]] double largest() const { return tree_[1]; }

 private:
  std::size_t n_;
  std::vector<double> tree_;
};

}  // namespace stylet
