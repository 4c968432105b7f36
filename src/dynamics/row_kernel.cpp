#include "stylet/dynamics/row_kernel.hpp"

#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#define STYLET_AVX2 __attribute__((target("avx2")))
#endif

namespace stylet {

namespace {

using Two = double __attribute__((vector_size(16)));

Two two(const double* from) {
  Two vector;
  std::memcpy(&vector, from, sizeof vector);
  return vector;
}

struct Force {
  double x;
  double y;
};

// Both rows of a node times a vector. Even and odd pairs of columns are summed apart, in all versions
// of this function, so that they give the same bits.
Force node_force(const RowMatrix& k, std::size_t row, const double* s) {
  const auto begin = static_cast<std::size_t>(k.first[row]);
  const auto end = static_cast<std::size_t>(k.first[row + 1]);
  const PetscInt* column = k.columns + begin;
  const double* k0 = k.values + begin;
  const double* k1 = k.values + end;
  const std::size_t width = end - begin;
  Two even0 = {0, 0};
  Two even1 = {0, 0};
  Two odd0 = {0, 0};
  Two odd1 = {0, 0};
  std::size_t j = 0;
  for (; j + 4 <= width; j += 4) {
    const Two first = two(s + column[j]);
    const Two second = two(s + column[j + 2]);
    even0 += two(k0 + j) * first;
    odd0 += two(k0 + j + 2) * second;
    even1 += two(k1 + j) * first;
    odd1 += two(k1 + j + 2) * second;
  }
  if (j < width) {
    const Two last = two(s + column[j]);
    even0 += two(k0 + j) * last;
    even1 += two(k1 + j) * last;
  }
  return {(even0[0] + even0[1]) + (odd0[0] + odd0[1]), (even1[0] + even1[1]) + (odd1[0] + odd1[1])};
}

#if defined(__x86_64__)
STYLET_AVX2 inline Force node_force_avx2(const RowMatrix& k, std::size_t row, const double* s) {
  const auto begin = static_cast<std::size_t>(k.first[row]);
  const auto end = static_cast<std::size_t>(k.first[row + 1]);
  const PetscInt* column = k.columns + begin;
  const double* k0 = k.values + begin;
  const double* k1 = k.values + end;
  const std::size_t width = end - begin;
  __m256d sum0 = _mm256_setzero_pd();
  __m256d sum1 = _mm256_setzero_pd();
  std::size_t j = 0;
  for (; j + 4 <= width; j += 4) {
    const __m256d both = _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(s + column[j])),
                                              _mm_loadu_pd(s + column[j + 2]), 1);
    sum0 = _mm256_add_pd(sum0, _mm256_mul_pd(_mm256_loadu_pd(k0 + j), both));
    sum1 = _mm256_add_pd(sum1, _mm256_mul_pd(_mm256_loadu_pd(k1 + j), both));
  }
  __m128d even0 = _mm256_castpd256_pd128(sum0);
  __m128d even1 = _mm256_castpd256_pd128(sum1);
  if (j < width) {
    const __m128d last = _mm_loadu_pd(s + column[j]);
    even0 = _mm_add_pd(even0, _mm_mul_pd(_mm_loadu_pd(k0 + j), last));
    even1 = _mm_add_pd(even1, _mm_mul_pd(_mm_loadu_pd(k1 + j), last));
  }
  // Sums of pairs, then even and odd.
  const __m128d both = _mm_hadd_pd(even0, even1);
  const __m128d odd = _mm_hadd_pd(_mm256_extractf128_pd(sum0, 1), _mm256_extractf128_pd(sum1, 1));
  const __m128d force = _mm_add_pd(both, odd);
  return {force[0], force[1]};
}
#endif

struct Factors {
  double half;
  double mass_factor;
  double damped;
};

inline void integrate(const ExplicitArrays& x, std::size_t i, double force, const Factors& f) {
  x.a[i] = ((x.load[i] - force) / x.mass[i] - f.mass_factor * x.v[i]) * f.damped;
  x.v[i] += f.half * x.a[i];
}

void accelerate_plain(const ExplicitArrays& x, const RowMatrix& k, const Factors& f) {
  for (std::size_t row = 0; row < x.n_dofs; row += 2) {
    const Force force = node_force(k, row, x.stretched);
    integrate(x, row, force.x, f);
    integrate(x, row + 1, force.y, f);
  }
}

#if defined(__x86_64__)
STYLET_AVX2 void accelerate_avx2(const ExplicitArrays& x, const RowMatrix& k, const Factors& f) {
  for (std::size_t row = 0; row < x.n_dofs; row += 2) {
    const Force force = node_force_avx2(k, row, x.stretched);
    integrate(x, row, force.x, f);
    integrate(x, row + 1, force.y, f);
  }
}
#endif

Factors factors(double h, double mass_factor) {
  const double half = 0.5 * h;
  return {half, mass_factor, 1 / (1 + half * mass_factor)};
}

}  // namespace

void predict(const ExplicitArrays& x, double h, double stiffness_factor) {
  const double* __restrict u0 = x.u0;
  const double* __restrict v0 = x.v0;
  const double* __restrict a0 = x.a0;
  double* __restrict u = x.u;
  double* __restrict v = x.v;
  double* __restrict stretched = x.stretched;
  const double half = 0.5 * h;
  for (std::size_t i = 0; i < x.n_dofs; ++i) {
    v[i] = v0[i] + half * a0[i];
    u[i] = u0[i] + h * v[i];
    stretched[i] = u[i] + stiffness_factor * v[i];
  }
}

void accelerate(const ExplicitArrays& x, const RowMatrix& k, double h, double mass_factor) {
#if defined(__x86_64__)
  static const bool avx2 = __builtin_cpu_supports("avx2");
  if (avx2) {
    accelerate_avx2(x, k, factors(h, mass_factor));
    return;
  }
#endif
  accelerate_plain(x, k, factors(h, mass_factor));
}

void accelerate(const ExplicitArrays& x, const double* force, double h, double mass_factor) {
  const Factors f = factors(h, mass_factor);
  for (std::size_t i = 0; i < x.n_dofs; ++i) integrate(x, i, force[i], f);
}

}  // namespace stylet
