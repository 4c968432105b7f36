#include "stylet/petsc/archive.hpp"

#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/gather.hpp"

#include <vector>

namespace stylet {

void archive_field(Archive& archive, const std::string& name, Vec field) {
  const auto& order = archive.order().nodes;
  std::vector<double> stored(2 * order.size());
  const auto each = [&](auto&& copy) {
    for (std::size_t i = 0; i < order.size(); ++i) {
      const auto to = static_cast<std::size_t>(order[i]);
      for (std::size_t k = 0; k < 2; ++k) copy(2 * i + k, 2 * to + k);
    }
  };
  if (!archive.loads()) {
    const auto values = gather_all(field);
    each([&](std::size_t from, std::size_t to) { stored[to] = values[from]; });
    archive.array(name, stored, 2);
    return;
  }
  archive.array(name, stored, 2);
  Entries values(field);
  each([&](std::size_t from, std::size_t to) {
    const int dof = static_cast<int>(to);
    if (values.owns(dof)) values[dof] = stored[from];
  });
}

}  // namespace stylet
