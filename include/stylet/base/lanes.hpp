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

/// V: Lanes or Pair.
template <class V = Lanes>
STYLET_INLINE V load_lanes(const double* values) {
  V v;
  std::memcpy(&v, values, sizeof v);
  return v;
}
template <class V>
STYLET_INLINE void store_lanes(double* to, const V& v) {
  std::memcpy(to, &v, sizeof v);
}
/// One number for each two lanes.
template <class V>
STYLET_INLINE V load_twice(const double* values) {
  if constexpr (sizeof(V) == sizeof(Pair)) {
    return V{values[0], values[0]};
  } else {
    const Pair both = load_lanes<Pair>(values);
    return __builtin_shufflevector(both, both, 0, 0, 1, 1);
  }
}
STYLET_INLINE double sum_of(const Lanes& v) {
  return (v[0] + v[2]) + (v[1] + v[3]);
}
STYLET_INLINE void add_lanes(Lanes& sum, const Lanes& v) {
  sum += v;
}
STYLET_INLINE void add_lanes(Lanes& sum, const Pair& v) {
  sum += Lanes{v[0], v[1], 0, 0};
}

}  // namespace stylet
