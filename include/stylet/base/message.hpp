// What is told of an exception, of whatever kind.
#pragma once

#include "stylet/base/errors.hpp"

#include <new>
#include <string>

namespace stylet {

[[nodiscard]] inline std::string message_of(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    return "not enough memory for this scene; use a coarser mesh or a larger machine";
  }
  const bool is_ours = dynamic_cast<const Error*>(&error) != nullptr ||
                       dynamic_cast<const Stopped*>(&error) != nullptr;
  return is_ours ? error.what() : std::string("internal error: ") + error.what();
}

}  // namespace stylet
