#include "stylet/study/design.hpp"

#include <algorithm>
#include <numeric>
#include <random>

namespace stylet {

namespace {

/// Own distributions: those of the standard library differ between libraries.
class Random {
 public:
  explicit Random(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}

  double unit() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  std::size_t below(std::size_t n) {
    return std::min(static_cast<std::size_t>(unit() * static_cast<double>(n)), n - 1);
  }
  std::vector<std::size_t> permutation(std::size_t n) {
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = n; i > 1; --i) std::swap(order[i - 1], order[below(i)]);
    return order;
  }

 private:
  std::mt19937_64 engine_;
};

std::vector<UnitPoint> uniform(std::size_t n, std::size_t d, Random& random) {
  std::vector<UnitPoint> points(n, UnitPoint(d));
  for (auto& point : points) std::ranges::generate(point, [&] { return random.unit(); });
  return points;
}

std::vector<UnitPoint> latin_hypercube(std::size_t n, std::size_t d, Random& random) {
  std::vector<UnitPoint> points(n, UnitPoint(d));
  for (std::size_t j = 0; j < d; ++j) {
    const auto cells = random.permutation(n);
    for (std::size_t i = 0; i < n; ++i) {
      points[i][j] = (static_cast<double>(cells[i]) + random.unit()) / static_cast<double>(n);
    }
  }
  return points;
}

std::vector<UnitPoint> morris(std::size_t n, std::size_t d, Random& random) {
  constexpr double spacing = 1.0 / (morris_levels - 1);
  constexpr double step = morris_levels / 2 * spacing;
  std::vector<UnitPoint> points;
  for (std::size_t t = 0; t < n; ++t) {
    UnitPoint point(d);
    std::vector<double> change(d);
    for (std::size_t j = 0; j < d; ++j) {
      point[j] = static_cast<double>(random.below(morris_levels)) * spacing;
      change[j] = point[j] + step > 1 + spacing / 2 ? -step : step;
    }
    points.push_back(point);
    for (const std::size_t j : random.permutation(d)) {
      point[j] += change[j];
      points.push_back(point);
    }
  }
  return points;
}

std::vector<UnitPoint> saltelli(std::size_t n, std::size_t d, Random& random) {
  const auto both = latin_hypercube(n, 2 * d, random);
  std::vector<UnitPoint> points;
  for (const auto& row : both) points.emplace_back(row.begin(), row.begin() + static_cast<long>(d));
  for (const auto& row : both) points.emplace_back(row.begin() + static_cast<long>(d), row.end());
  for (std::size_t j = 0; j < d; ++j) {
    for (std::size_t i = 0; i < n; ++i) {
      points.push_back(points[i]);
      points.back()[j] = points[n + i][j];
    }
  }
  return points;
}

}  // namespace

std::vector<UnitPoint> sample(Design design, int n, std::size_t d, int seed) {
  Random random(seed);
  const auto size = static_cast<std::size_t>(n);
  switch (design) {
    case Design::latin_hypercube:
      return latin_hypercube(size, d, random);
    case Design::morris:
      return morris(size, d, random);
    case Design::sobol:
      return saltelli(size, d, random);
    case Design::random:
      return uniform(size, d, random);
    case Design::one_at_a_time:
    case Design::grid:
      break;
  }
  return {};
}

}  // namespace stylet
