#include "stylet/needle/rest_compliance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace stylet {

namespace {

// Of the smallest ring: where the grid starts, and how it grows. Interpolation then costs no more than 1e-7
// of an entry between segments of 0.5 mm that are 100 mm apart.
constexpr double first = 1e-3;
constexpr double growth = 1.05;

// Points and weights of Gauss and Legendre on (0, 1), exact to degree 7.
constexpr std::array<std::pair<double, double>, 4> gauss{
    {{0.0694318442029737, 0.1739274225687269},
     {0.3300094782075719, 0.3260725774312731},
     {0.6699905217924281, 0.3260725774312731},
     {0.9305681557970263, 0.1739274225687269}}};

}  // namespace

RingPrimitives::RingPrimitives(double radius, std::span<const Ring> kernel, double reach) {
  const Ring own[1] = {{radius, 1}};
  const auto mean = [&](double s) { return ring_means(s, own) - ring_means(s, kernel); };
  double smallest = radius;
  for (const Ring& ring : kernel) smallest = std::min(smallest, ring.radius);

  // mean(s) = mean(s0) - slope ln(s/s0) for s <= s0
  double s = first * smallest;
  const RingMeans at_first = mean(s);
  log_slope_ = 1 / std::numbers::ln2 * (mean(s / 2) - at_first);
  Value value{s * s * (0.5 * at_first + 0.75 * log_slope_), s * (at_first + log_slope_), at_first};
  s_.push_back(s);
  values_.push_back(value);
  while (s < reach) {
    const double h = (growth - 1) * s;
    RingMeans once;
    RingMeans twice = h * value.once;
    for (const auto& [x, weight] : gauss) {
      const RingMeans here = mean(s + h * x);
      once = once + h * weight * here;
      twice = twice + h * h * weight * (1 - x) * here;
    }
    s += h;
    value = {value.twice + twice, value.once + once, mean(s)};
    s_.push_back(s);
    values_.push_back(value);
  }
}

RingPrimitives::Value RingPrimitives::at(double s) const {
  if (s <= 0) return {};
  if (s <= s_.front()) {
    const RingMeans mean = values_.front().mean + std::log(s_.front() / s) * log_slope_;
    return {s * s * (0.5 * mean + 0.75 * log_slope_), s * (mean + log_slope_), mean};
  }
  const auto next = std::upper_bound(s_.begin(), s_.end() - 1, s);
  const auto i = static_cast<std::size_t>(next - s_.begin());
  const Value& a = values_[i - 1];
  const Value& b = values_[i];
  // Hermite's polynomial of degree five through both ends, and its derivatives.
  const double h = s_[i] - s_[i - 1];
  const double x = (s - s_[i - 1]) / h;
  const RingMeans linear = h * a.once;
  const RingMeans square = 0.5 * h * h * a.mean;
  const RingMeans rise = b.twice - a.twice - linear - square;
  const RingMeans slope = h * b.once - linear - 2 * square;
  const RingMeans bend = h * h * (b.mean - a.mean);
  const RingMeans third = 10 * rise - 4 * slope + 0.5 * bend;
  const RingMeans fourth = -15 * rise + 7 * slope - bend;
  const RingMeans fifth = 6 * rise - 3 * slope + 0.5 * bend;
  const auto polynomial = [x](const std::array<RingMeans, 6>& c) {
    RingMeans sum;
    for (auto k = c.rbegin(); k != c.rend(); ++k) sum = *k + x * sum;
    return sum;
  };
  return {polynomial({a.twice, linear, square, third, fourth, fifth}),
          1 / h * polynomial({linear, 2 * square, 3 * third, 4 * fourth, 5 * fifth, {}}),
          1 / (h * h) * polynomial({2 * square, 6 * third, 12 * fourth, 20 * fifth, {}, {}})};
}

RestCompliance::RestCompliance(double radius,
                               std::span<const Ring> kernel,
                               double length,
                               bool below_skin)
    : primitives_(radius, kernel, below_skin ? 2 * length : length), below_skin_(below_skin) {}

RestCompliance::Parts RestCompliance::parts(const TrackSegment& a, const TrackSegment& b) const {
  const double pairs = 1 / (a.length() * b.length());
  const auto twice = [&](double s) { return primitives_.at(std::abs(s)).twice; };
  Parts parts{};
  parts.near = pairs * (twice(a.to - b.from) - twice(a.to - b.to) - twice(a.from - b.from) +
                        twice(a.from - b.to));
  if (!below_skin_) return parts;
  for (const auto& [z, of_z] : {std::pair(a.to, pairs), {a.from, -pairs}}) {
    for (const auto& [c, of_c] : {std::pair(b.to, of_z), {b.from, -of_z}}) {
      const auto value = primitives_.at(z + c);
      parts.image = parts.image + of_c * value.twice;
      // Its derivative by z and c is z c A''.
      parts.bent +=
          of_c * (z * c * value.mean.inverse - (z + c) * value.once.inverse + value.twice.inverse);
    }
  }
  return parts;
}

double RestCompliance::along(const TrackSegment& a, const TrackSegment& b) const {
  const double nu = (a.poisson_ratio + b.poisson_ratio) / 2;
  const double g = std::sqrt(a.shear_modulus * b.shear_modulus);
  const auto [near, image, bent] = parts(a, b);
  const double stiff = 3 - 4 * nu;
  return kelvin_along(near, g, nu) +
         kelvin_factor(g, nu) *
             ((8 * (1 - nu) * (1 - nu) - stiff) * image.inverse + stiff * image.axial + 2 * bent);
}

double RestCompliance::across(const TrackSegment& a, const TrackSegment& b) const {
  const double nu = (a.poisson_ratio + b.poisson_ratio) / 2;
  const double g = std::sqrt(a.shear_modulus * b.shear_modulus);
  const auto [near, image, bent] = parts(a, b);
  const double stiff = 3 - 4 * nu;
  return kelvin_across(near, g, nu) +
         kelvin_factor(g, nu) * ((1 + stiff / 2 + 2 * (1 - nu) * (1 - 2 * nu)) * image.inverse -
                                 stiff / 2 * image.axial + bent);
}

}  // namespace stylet
