// Four doubles at a time. Functions marked STYLET_LANES are compiled for AVX2 too and take it where
// the machine has it, with the same bits; what they call has to be STYLET_INLINE.
#pragma once

#include <cstring>

#define STYLET_INLINE __attribute__((always_inline)) inline
#define STYLET_INNER __attribute__((always_inline))  // of a lambda
#if defined(__x86_64__)
#define STYLET_LANES __attribute__((target_clones("avx2", "default")))
#else
#define STYLET_LANES
#endif
// All are inlined, so no vector goes through a call.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace stylet {

using Pair [[gnu::vector_size(16)]] = double;
using Lanes [[gnu::vector_size(32)]] = double;

STYLET_INLINE Lanes load_lanes(const double* values) {
  Lanes v;
  std::memcpy(&v, values, sizeof v);
  return v;
}

}  // namespace stylet
