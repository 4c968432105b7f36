#include "stylet/study/richardson.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stylet {

namespace {

constexpr double lowest_order = 0.5;
constexpr double above_formal = 0.1;
constexpr double careful = 3;
constexpr double usual = 1.25;

/// values = limit + factor h^order, with the finest h = 1.
struct Fit {
  double limit = 0;
  double factor = 0;
  double squares = 0;  ///< sum of squared residuals
};

Fit fit(std::span<const double> values, double ratio, double order) {
  const auto n = static_cast<double>(values.size());
  double x_mean = 0;
  double y_mean = 0;
  std::vector<double> x(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    x[i] = std::pow(ratio, order * static_cast<double>(values.size() - 1 - i));
    x_mean += x[i] / n;
    y_mean += values[i] / n;
  }
  double xx = 0;
  double xy = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    xx += (x[i] - x_mean) * (x[i] - x_mean);
    xy += (x[i] - x_mean) * (values[i] - y_mean);
  }
  Fit result;
  result.factor = xy / xx;
  result.limit = y_mean - result.factor * x_mean;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double residual = values[i] - result.limit - result.factor * x[i];
    result.squares += residual * residual;
  }
  return result;
}

/// The order that fits best; the ends of the search mean that the values tell none.
double fitted_order(std::span<const double> values, double ratio) {
  constexpr double first = 0.05;
  constexpr double last = 8;
  constexpr double spacing = 0.005;
  double best = std::numeric_limits<double>::quiet_NaN();
  double least = std::numeric_limits<double>::infinity();
  for (double order = first; order < last; order += spacing) {
    const double squares = fit(values, ratio, order).squares;
    if (squares < least) {
      least = squares;
      best = order;
    }
  }
  return best;
}

}  // namespace

Extrapolation extrapolate_known(double at_size, double at_smaller, double ratio, double order) {
  Extrapolation result;
  result.order = order;
  result.safety = usual;
  const double gained = std::pow(ratio, order) - 1;
  result.limit = at_smaller + (at_smaller - at_size) / gained;
  for (const double value : {at_size, at_smaller}) {
    result.uncertainty.push_back(usual * std::abs(value - result.limit));
  }
  return result;
}

Extrapolation extrapolate(std::span<const double> values, double ratio, double formal_order) {
  Extrapolation result;
  const std::size_t n = values.size();
  const double finest = values[n - 1];
  const double last_change = finest - values[n - 2];
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto [low, high] = std::ranges::minmax(values);
  const double spread = high - low;
  result.order = nan;
  if (n == 2) {
    result.remark = "two levels do not tell an order";
  } else if (n == 3) {
    const double quotient = (values[1] - values[0]) / last_change;
    if (spread == 0) {
      result.remark = "no change from level to level";
    } else if (quotient > 0) {
      result.order = std::log(quotient) / std::log(ratio);
    } else {
      result.remark = "the values go up and down";
    }
  } else if (spread == 0) {
    result.remark = "no change from level to level";
  } else {
    result.order = fitted_order(values, ratio);
  }
  const bool sensible = result.order >= lowest_order && result.order <= formal_order + above_formal;
  if (!sensible && result.remark.empty()) {
    result.remark = result.order < lowest_order
                        ? "the order is below 0.5: no sure sign of convergence"
                        : "the order is above the formal one";
  }
  result.safety = sensible ? usual : careful;
  result.limit = finest;
  if (sensible) {
    const Fit best = fit(values, ratio, result.order);
    result.limit = best.limit;
    if (n > 3) result.scatter = std::sqrt(best.squares / static_cast<double>(n - 3));
  }
  // Without a trustworthy order: the changes themselves, as if of first order (or of the formal one
  // where they fall faster), and never less than what the levels differ by afterwards.
  const double assumed = result.order > formal_order ? formal_order : 1.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (sensible) {
      const double error = std::abs(values[i] - result.limit);
      result.uncertainty.push_back(result.safety * error + result.scatter);
      continue;
    }
    const double change = i + 1 < n ? std::abs(values[i + 1] - values[i]) : std::abs(last_change);
    double later = 0;
    for (std::size_t j = i + 1; j < n; ++j)
      later = std::max(later, std::abs(values[j] - values[i]));
    const double by_order = i + 1 < n ? change / (1 - std::pow(ratio, -assumed))
                                      : change / (std::pow(ratio, assumed) - 1);
    result.uncertainty.push_back(careful * std::max(by_order, later));
  }
  return result;
}

}  // namespace stylet
