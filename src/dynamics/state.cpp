#include "stylet/dynamics/state.hpp"

namespace stylet {

std::vector<int> dofs_of(std::span<const int> nodes, int dim) {
  std::vector<int> dofs;
  dofs.reserve(static_cast<std::size_t>(dim) * nodes.size());
  for (const int node : nodes) {
    for (int k = 0; k < dim; ++k) dofs.push_back(dim * node + k);
  }
  return dofs;
}

}  // namespace stylet
