#include "stylet/dynamics/state.hpp"

namespace stylet {

std::vector<int> dofs_of(std::span<const int> nodes) {
  std::vector<int> dofs;
  dofs.reserve(2 * nodes.size());
  for (const int node : nodes) {
    dofs.push_back(2 * node);
    dofs.push_back(2 * node + 1);
  }
  return dofs;
}

}  // namespace stylet
