// What is left of values at even steps when a cubic is taken off.
#pragma once

#include <cmath>
#include <numeric>
#include <vector>

namespace stylet {

/// rms of the rest, of the values' own.
inline double jitter(const std::vector<double>& values) {
  const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  // Projections onto polynomials that are made orthogonal on these places.
  std::vector<std::vector<double>> basis;
  std::vector<double> rest = values;
  for (int degree = 0; degree < 4; ++degree) {
    std::vector<double> p;
    for (std::size_t i = 0; i < values.size(); ++i) {
      p.push_back(std::pow(
          2.0 * static_cast<double>(i) / static_cast<double>(values.size() - 1) - 1, degree));
    }
    for (const auto& q : basis) {
      const double part = product(p, q) / product(q, q);
      for (std::size_t i = 0; i < p.size(); ++i) p[i] -= part * q[i];
    }
    const double part = product(rest, p) / product(p, p);
    for (std::size_t i = 0; i < p.size(); ++i) rest[i] -= part * p[i];
    basis.push_back(p);
  }
  return std::sqrt(product(rest, rest) / product(values, values));
}

}  // namespace stylet
