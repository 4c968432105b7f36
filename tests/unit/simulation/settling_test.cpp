#include "stylet/simulation/settling.hpp"

#include "stylet/base/errors.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

namespace stylet {
namespace {

constexpr double tolerance = 1e-9;

/// Steps until rest, or -1 if that is given up, which has to be soon.
long steps_to_rest(const std::function<double(long)>& speed) {
  Settling settling;
  for (long n = 0; n < 400000; ++n) {
    try {
      if (settling.is_settled(speed(n), tolerance)) return n;
    } catch (const NumericalError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("does not come to rest"));
      EXPECT_LT(n, 20000);
      return -1;
    }
  }
  return 400000;
}

TEST(Settling, WaitsForWhatFalls) {
  EXPECT_EQ(steps_to_rest([](long) { return tolerance; }), 0);
  const auto falls = [](double rate) {
    return steps_to_rest([rate](long n) { return std::exp(-rate * static_cast<double>(n)); });
  };
  const double to_fall = -std::log(tolerance);
  for (const double rate : {0.1, 1e-2, 1e-3, 1e-4}) {
    EXPECT_NEAR(static_cast<double>(falls(rate)), to_fall / rate, 1) << rate;
  }
  // Rises at first, as where a needle lets go; swings while it falls.
  EXPECT_GT(steps_to_rest([](long n) {
              const double t = static_cast<double>(n) + 1;
              return (1 - std::exp(-0.01 * t)) * std::exp(-0.002 * t) *
                     (1 + 0.9 * std::sin(0.004 * t));
            }),
            5000);
}

TEST(Settling, GivesUpWhatDoesNot) {
  EXPECT_EQ(steps_to_rest([](long) { return 1e-3; }), -1);
  EXPECT_EQ(
      steps_to_rest([](long n) { return std::abs(std::sin(0.3 * static_cast<double>(n) + 0.1)); }),
      -1);
  EXPECT_EQ(steps_to_rest([](long n) { return 1e-3 * (1 + 1e-5 * static_cast<double>(n)); }), -1);
  EXPECT_EQ(steps_to_rest([](long n) { return std::exp(-1e-6 * static_cast<double>(n)); }), -1);
  // Falls, then stays at round-off.
  EXPECT_EQ(steps_to_rest([](long n) { return 2e-9 + std::exp(-0.05 * static_cast<double>(n)); }),
            -1);
}

TEST(Settling, BeginsAnewWhereTheTissueIsStillMoved) {
  Settling settling;
  for (int n = 0; n < 100000; ++n) {
    EXPECT_FALSE(settling.is_settled(1e-3, tolerance));
    if (n % 400 == 0) settling.restart();
  }
}

}  // namespace
}  // namespace stylet
