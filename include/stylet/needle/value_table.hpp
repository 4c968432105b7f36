// Values of a few nodes of the mesh, or points of a track.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

namespace stylet {

template <class Value>
class ValueTable {
 public:
  ValueTable() = default;
  /// keys: ascending.
  ValueTable(std::vector<int> keys, std::vector<Value> values)
      : keys_(std::move(keys)), values_(std::move(values)) {}
  [[nodiscard]] const Value& at(int key) const {
    const auto found = std::ranges::lower_bound(keys_, key);
    if (found == keys_.end() || *found != key) throw std::out_of_range("no such node or point");
    return values_[static_cast<std::size_t>(found - keys_.begin())];
  }
  [[nodiscard]] const std::vector<int>& keys() const { return keys_; }

 private:
  std::vector<int> keys_;
  std::vector<Value> values_;
};

}  // namespace stylet
