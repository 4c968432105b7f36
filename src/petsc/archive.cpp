#include "stylet/petsc/archive.hpp"

#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/gather.hpp"

#include <vector>

namespace stylet {

void archive_field(Archive& archive, const std::string& name, Vec field) {
  const auto& order = archive.order().nodes;
  const auto dim = static_cast<std::size_t>(archive.order().dim);
  std::vector<double> stored(dim * order.size());
  const auto each = [&](auto&& copy) {
    for (std::size_t i = 0; i < order.size(); ++i) {
      const auto to = static_cast<std::size_t>(order[i]);
      for (std::size_t k = 0; k < dim; ++k) copy(dim * i + k, dim * to + k);
    }
  };
  if (!archive.loads()) {
    const auto values = gather_all(field);
    each([&](std::size_t from, std::size_t to) { stored[to] = values[from]; });
    archive.array(name, stored, dim);
    return;
  }
  archive.array(name, stored, dim);
  Entries values(field);
  each([&](std::size_t from, std::size_t to) {
    const int dof = static_cast<int>(to);
    if (values.owns(dof)) values[dof] = stored[from];
  });
}

}  // namespace stylet
