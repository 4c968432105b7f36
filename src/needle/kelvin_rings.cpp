#include "stylet/needle/kelvin_rings.hpp"

#include "stylet/base/errors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace stylet {

namespace {

constexpr double pi = std::numbers::pi;

}  // namespace

RingMeans ring_means(double s, double a, double b) {
  const double longest = std::hypot(s, a + b);
  const double shortest = std::hypot(s, a - b);
  // 1 - (shortest/longest)^2
  const double modulus = 2 * std::sqrt(a * b) / longest;
  const double tilt = s / shortest;
  return {2 / pi * std::comp_ellint_1(modulus) / longest,
          2 / pi * std::comp_ellint_2(modulus) * tilt * tilt / longest};
}

double kelvin_factor(double shear_modulus, double poisson_ratio) {
  return 1 / (16 * pi * shear_modulus * (1 - poisson_ratio));
}

double kelvin_along(RingMeans means, double shear_modulus, double poisson_ratio) {
  return kelvin_factor(shear_modulus, poisson_ratio) *
         ((3 - 4 * poisson_ratio) * means.inverse + means.axial);
}

double kelvin_across(RingMeans means, double shear_modulus, double poisson_ratio) {
  return kelvin_factor(shear_modulus, poisson_ratio) *
         ((3 - 4 * poisson_ratio) * means.inverse + (means.inverse - means.axial) / 2);
}

std::vector<Ring> disc_rings(double radius, int n) {
  const auto degree = static_cast<unsigned>(n);
  const auto slope = [&](double x) {
    return n * (x * std::legendre(degree, x) - std::legendre(degree - 1, x)) / (x * x - 1);
  };
  std::vector<Ring> rings;
  for (int i = n; i > 0; --i) {
    // Newton's iteration for a zero on (-1, 1) converges from here: Abramowitz and Stegun, 22.16.6.
    double x = std::cos(pi * (i - 0.25) / (n + 0.5));
    double change = 1;
    while (std::abs(change) > 1e-9) {
      change = std::legendre(degree, x) / slope(x);
      x -= change;
    }
    rings.push_back({radius * std::sqrt((1 + x) / 2), 1 / ((1 - x * x) * slope(x) * slope(x))});
  }
  return rings;
}

std::vector<Ring> kernel_rings(double kernel_radius, double radius, int n) {
  if (kernel_radius <= radius) return {{radius, 1}};
  auto rings = disc_rings(kernel_radius, n);
  const double effective = effective_radius(rings);
  if (effective <= radius) {
    std::ostringstream text;
    text << "a kernel_radius of " << 1e3 * kernel_radius << " mm moves like a needle of "
         << 1e3 * effective << " mm, which is not wider than the needle's own radius of "
         << 1e3 * radius << " mm: take at least " << 1e3 * radius * kernel_radius / effective
         << " mm, or no more than the needle's own radius";
    throw InputError(text.str());
  }
  return rings;
}

RingMeans ring_means(double s, std::span<const Ring> rings) {
  RingMeans sum;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const double pairs = i == j ? 1 : 2;
      sum = sum + pairs * rings[i].weight * rings[j].weight *
                      ring_means(s, rings[i].radius, rings[j].radius);
    }
  }
  return sum;
}

double effective_radius(std::span<const Ring> rings) {
  double log_radius = 0;
  for (const Ring& a : rings) {
    for (const Ring& b : rings) {
      log_radius += a.weight * b.weight * std::log(std::max(a.radius, b.radius));
    }
  }
  return std::exp(log_radius);
}

}  // namespace stylet
