// Numbers of nodes, dofs and the like as indices.
#pragma once

#include <cstddef>

namespace stylet {

template <class Number>
constexpr std::size_t at(Number i) {
  return static_cast<std::size_t>(i);
}

}  // namespace stylet
