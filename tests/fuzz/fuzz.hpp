// What the fuzz targets share. Each takes any bytes: it may refuse them with an InputError, and
// nothing else may happen. Where it takes them, it checks what has to hold of the result.
#pragma once

#include "stylet/base/errors.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace stylet::fuzz {

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Ends the process: a thrown error could be taken for a refusal.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: does not hold: %s\n", what);
  std::abort();
}

template <class Body>
void may_refuse(Body&& body) {
  try {
    body();
  } catch (const InputError&) {
    return;  // the good answer to most inputs
  }
}

}  // namespace stylet::fuzz
