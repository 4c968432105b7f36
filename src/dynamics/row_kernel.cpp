#include "stylet/dynamics/row_kernel.hpp"

#include "stylet/petsc/check.hpp"

#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#define STYLET_AVX2 __attribute__((target("avx2")))
#endif

namespace stylet {

namespace {

/// A SeqAIJ matrix's arrays, lent.
class Arrays {
 public:
  explicit Arrays(Mat k) : k_(k) {
    PetscBool done = PETSC_FALSE;
    check(MatGetRowIJ(k, 0, PETSC_FALSE, PETSC_FALSE, &n_rows, &first, &columns, &done));
    check(MatSeqAIJGetArrayRead(k, &values));
  }
  Arrays(const Arrays&) = delete;
  Arrays& operator=(const Arrays&) = delete;
  ~Arrays() {
    PetscBool done = PETSC_FALSE;
    (void)MatSeqAIJRestoreArrayRead(k_, &values);
    (void)MatRestoreRowIJ(k_, 0, PETSC_FALSE, PETSC_FALSE, &n_rows, &first, &columns, &done);
  }
  PetscInt n_rows = 0;
  const PetscInt* first = nullptr;
  const PetscInt* columns = nullptr;
  const PetscScalar* values = nullptr;

 private:
  Mat k_;
};

struct Vector {
  double x;
  double y;
};

// Even and odd blocks are summed apart, in all versions of this function, so that they give the same
// bits.
Vector node_force(const BlockRows::Row& row, const double* s) {
  double sum[2][4] = {};
  for (std::size_t j = 0; j < row.n; ++j) {
    const double* k = row.values + 4 * j;
    const double* x = s + 2 * static_cast<std::size_t>(row.columns[j]);
    for (std::size_t i = 0; i < 4; ++i) sum[j % 2][i] += k[i] * x[i % 2];
  }
  for (std::size_t i = 0; i < 4; ++i) sum[0][i] += sum[1][i];
  return {sum[0][0] + sum[0][1], sum[0][2] + sum[0][3]};
}

#if defined(__x86_64__)
STYLET_AVX2 inline Vector node_force_avx2(const BlockRows::Row& row, const double* s) {
  const auto product = [&](std::size_t j) STYLET_AVX2 {
    const auto* x =
        reinterpret_cast<const __m128d*>(s + 2 * static_cast<std::size_t>(row.columns[j]));
    return _mm256_mul_pd(_mm256_loadu_pd(row.values + 4 * j), _mm256_broadcast_pd(x));
  };
  // Rows to come: without it large meshes take a quarter longer, since the gathers from s stand in the
  // way of the stream.
  constexpr std::size_t ahead = 256;
  constexpr std::size_t cache_line = 8;
  for (std::size_t i = 0; i < 4 * row.n; i += cache_line) {
    _mm_prefetch(reinterpret_cast<const char*>(row.values + ahead + i), _MM_HINT_T0);
  }
  __m256d even = _mm256_setzero_pd();
  __m256d odd = _mm256_setzero_pd();
  std::size_t j = 0;
  for (; j + 2 <= row.n; j += 2) {
    even = _mm256_add_pd(even, product(j));
    odd = _mm256_add_pd(odd, product(j + 1));
  }
  if (j < row.n) even = _mm256_add_pd(even, product(j));
  const __m256d sum = _mm256_add_pd(even, odd);
  const __m128d force = _mm_hadd_pd(_mm256_castpd256_pd128(sum), _mm256_extractf128_pd(sum, 1));
  return {force[0], force[1]};
}
#endif

struct Factors {
  double half;
  double mass_factor;
  double damped;
};

// The loops of all versions; force(node) is K stretched. Locals, since stores might change the structure.
template <class Force>
__attribute__((always_inline)) inline Power integrate(const ExplicitArrays& x,
                                                      const Factors& f,
                                                      Force&& force) {
  const std::size_t n = x.n_nodes;
  const double* const load = x.load;
  const double* const inverse_root = x.inverse_root;
  double* const v = x.v;
  double* const a = x.a;
  const auto [half, mass_factor, damped] = f;
  Power power;
  for (std::size_t node = 0; node < n; ++node) {
    const std::size_t i = 2 * node;
    const double inverse = inverse_root[node] * inverse_root[node];
    const double v0 = v[i];
    const double v1 = v[i + 1];
    Vector rest = force(node);
    rest = {-rest.x, -rest.y};
    if (load != nullptr) {
      rest.x += load[i];
      rest.y += load[i + 1];
      power.load += load[i] * v0 + load[i + 1] * v1;
    }
    const double a0 = (rest.x * inverse - mass_factor * v0) * damped;
    const double a1 = (rest.y * inverse - mass_factor * v1) * damped;
    a[i] = a0;
    a[i + 1] = a1;
    v[i] = v0 + half * a0;
    v[i + 1] = v1 + half * a1;
    power.rest += rest.x * v0 + rest.y * v1;
  }
  return power;
}

Power accelerate_plain(const ExplicitArrays& x, const BlockRows& k, const Factors& f) {
  const auto rows = k.view();
  const double* const s = x.stretched;
  return integrate(x, f, [=](std::size_t node) { return node_force(rows[node], s); });
}

#if defined(__x86_64__)
STYLET_AVX2 Power accelerate_avx2(const ExplicitArrays& x, const BlockRows& k, const Factors& f) {
  const auto rows = k.view();
  const double* const s = x.stretched;
  return integrate(x, f,
                   [=](std::size_t node) STYLET_AVX2 { return node_force_avx2(rows[node], s); });
}
#endif

Factors factors(double h, double mass_factor) {
  const double half = 0.5 * h;
  return {half, mass_factor, 1 / (1 + half * mass_factor)};
}

}  // namespace

BlockRows::BlockRows(Mat k) {
  const Arrays from(k);
  const auto n = static_cast<std::size_t>(from.n_rows / 2);
  first_.resize(n + 1);
  for (std::size_t node = 0; node <= n; ++node) {
    first_[node] = static_cast<std::size_t>(from.first[2 * node]) / 4;
  }
  columns_.resize(first_[n]);
  values_.resize(4 * first_[n]);
  std::vector<int> all(n);
  for (std::size_t node = 0; node < n; ++node) all[node] = static_cast<int>(node);
  update(k, all);
}

void BlockRows::update(Mat k, std::span<const int> nodes) {
  const Arrays from(k);
  for (const int node : nodes) {
    const auto at = static_cast<std::size_t>(node);
    const auto begin = static_cast<std::size_t>(from.first[2 * at]);
    const auto width = static_cast<std::size_t>(from.first[2 * at + 1]) - begin;
    if (width != 2 * (first_[at + 1] - first_[at])) {
      *this = BlockRows(k);
      return;
    }
    for (std::size_t j = 0; j < width; j += 2) {
      const std::size_t block = first_[at] + j / 2;
      columns_[block] = from.columns[begin + j] / 2;
      std::memcpy(&values_[4 * block], from.values + begin + j, 2 * sizeof(double));
      std::memcpy(&values_[4 * block + 2], from.values + begin + width + j, 2 * sizeof(double));
    }
  }
}

MassWork predict(const ExplicitArrays& x, double h, double stiffness_factor) {
  const double half = 0.5 * h;
  const std::size_t n = x.n_nodes;
  const double* const mass = x.mass;
  const double* const u0 = x.u0;
  const double* const v0 = x.v0;
  const double* const a0 = x.a0;
  double* const u = x.u;
  double* const v = x.v;
  double* const stretched = stiffness_factor != 0 ? x.stretched : nullptr;
  MassWork work;
  for (std::size_t node = 0; node < n; ++node) {
    double start = 0;
    double middle = 0;
    for (std::size_t i = 2 * node; i < 2 * node + 2; ++i) {
      const double before = v0[i];
      const double now = before + half * a0[i];
      const double place = u0[i] + h * now;
      v[i] = now;
      u[i] = place;
      if (stretched != nullptr) stretched[i] = place + stiffness_factor * now;
      start += before * now;
      middle += now * now;
    }
    work.start += mass[node] * start;
    work.half += mass[node] * middle;
  }
  return work;
}

Power accelerate(const ExplicitArrays& x, const BlockRows& k, double h, double mass_factor) {
#if defined(__x86_64__)
  static const bool avx2 = __builtin_cpu_supports("avx2");
  if (avx2) return accelerate_avx2(x, k, factors(h, mass_factor));
#endif
  return accelerate_plain(x, k, factors(h, mass_factor));
}

Power accelerate(const ExplicitArrays& x, const double* force, double h, double mass_factor) {
  return integrate(x, factors(h, mass_factor), [=](std::size_t node) {
    return Vector{force[2 * node], force[2 * node + 1]};
  });
}

}  // namespace stylet
