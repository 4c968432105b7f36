#include "stylet/base/archive.hpp"

#include "stylet/base/errors.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

void Archive::refuse(const std::string& why) const {
  throw InputError("what was stored does not fit: '" + path_ + "' " + why);
}

template <class T>
void Archive::next(T& value) {
  if (!loads_) {
    Column& column = columns_.try_emplace(path_, Column{std::vector<T>{}}).first->second;
    std::get<std::vector<T>>(column.values).push_back(value);
    return;
  }
  const auto found = columns_.find(path_);
  if (found == columns_.end()) refuse("is missing");
  auto* values = std::get_if<std::vector<T>>(&found->second.values);
  if (values == nullptr) refuse("is of another kind");
  if (found->second.next >= values->size()) refuse("is too short");
  value = (*values)[found->second.next++];
}

static void require_number(bool is_number, bool loads, const std::string& path) {
  if (is_number) return;
  if (!loads) throw NumericalError("what is to be stored is not a number: '" + path + "'");
  throw InputError("what was stored is not a number: '" + path + "'; begin anew with --force");
}

// Limits that do not limit are infinite.
void Archive::scalar(double& value) {
  next(value);
  require_number(!std::isnan(value), loads_, path_);
}
void Archive::scalar(std::int64_t& value) {
  next(value);
}
void Archive::scalar(std::string& value) {
  next(value);
}

void Archive::finish() const {
  for (const auto& [name, column] : columns_) {
    const auto size = std::visit([](const auto& values) { return values.size(); }, column.values);
    if (column.next == size) continue;
    throw InputError("what was stored does not fit: '" + name + "' has " + std::to_string(size) +
                     " values, and " + std::to_string(column.next) + " are known");
  }
}

int Archive::renumbered(const std::vector<int>& order, int number) const {
  if (number < 0) return number;
  if (static_cast<std::size_t>(number) >= order.size()) refuse("is no number of the mesh");
  return order[static_cast<std::size_t>(number)];
}

void Archive::node(const std::string& name, int& number) {
  int stored = loads_ ? 0 : renumbered(order_.nodes, number);
  (*this)(name, stored);
  const Below below(*this, name);
  if (loads_) number = renumbered(order_.nodes, stored);
}

void Archive::dof(const std::string& name, int& number) {
  const int dim = order_.dim;
  int stored = loads_ ? 0 : dim * renumbered(order_.nodes, number / dim) + number % dim;
  (*this)(name, stored);
  const Below below(*this, name);
  if (loads_) number = dim * renumbered(order_.nodes, stored / dim) + stored % dim;
}

void Archive::cell(const std::string& name, int& number) {
  int stored = loads_ ? 0 : renumbered(order_.cells, number);
  (*this)(name, stored);
  const Below below(*this, name);
  if (loads_) number = renumbered(order_.cells, stored);
}

void Archive::nodes(const std::string& name, std::vector<int>& numbers) {
  std::size_t size = numbers.size();
  (*this)(name + "/size", size);
  if (loads_) numbers.resize(size);
  for (int& number : numbers) node(name + "/each", number);
}

void Archive::cells(const std::string& name, std::vector<int>& numbers) {
  std::size_t size = numbers.size();
  (*this)(name + "/size", size);
  if (loads_) numbers.resize(size);
  for (int& number : numbers) cell(name + "/each", number);
}

template <class T>
void Archive::fixed(std::span<T> values, std::size_t width) {
  using Stored = std::conditional_t<std::is_same_v<T, int>, std::int64_t, T>;
  if (!loads_) {
    columns_[path_] = {std::vector<Stored>(values.begin(), values.end()), width};
    return;
  }
  const auto found = columns_.find(path_);
  if (found == columns_.end()) refuse("is missing");
  auto* stored = std::get_if<std::vector<Stored>>(&found->second.values);
  if (stored == nullptr) refuse("is of another kind");
  if (stored->size() != values.size()) refuse("is of another size");
  std::ranges::transform(*stored, values.begin(), [](Stored v) { return static_cast<T>(v); });
  found->second.next = stored->size();
}

void Archive::array(const std::string& name, std::span<double> values, std::size_t width) {
  const Below below(*this, name);
  fixed(values, width);
  const bool all = std::ranges::all_of(values, [](double v) { return std::isfinite(v); });
  require_number(all, loads_, path_);
}

void Archive::array(const std::string& name, std::span<int> values, std::size_t width) {
  const Below below(*this, name);
  fixed(values, width);
}

}  // namespace stylet
