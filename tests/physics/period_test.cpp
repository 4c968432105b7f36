// Period of the Newmark family: cos(omega_num h) = 1 - (W^2/2)/(1 + beta W^2) with W = omega h, read
// from u_{n+1} + u_{n-1} = 2 cos(omega_num h) u_n.
#include "support/oscillator.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

double newmark_cosine(double big_omega, double beta) {
  const double square = big_omega * big_omega;
  return 1 - 0.5 * square / (1 + beta * square);
}

// Largest difference to the recurrence over some steps, relative to the amplitude.
double recurrence_error(const TimeParameters& time, double big_omega, double cosine) {
  Oscillator oscillator(time);
  const double omega = oscillator.omega();
  oscillator.set({1, 0.3 * omega, -omega * omega});
  std::vector<double> u{1};
  for (int n = 0; n < 50; ++n) {
    oscillator.step(big_omega / omega);
    u.push_back(oscillator.get()[0]);
  }
  double error = 0;
  for (std::size_t n = 1; n + 1 < u.size(); ++n) {
    error = std::max(error, std::abs(u[n + 1] + u[n - 1] - 2 * cosine * u[n]));
  }
  return error / largest(u);
}

TEST(Period, AverageAccelerationIsBetaOneQuarter) {
  TimeParameters time;
  time.scheme = ImplicitScheme::average_acceleration;
  for (const double big_omega : {0.1, 0.5, 1.0, 2.0, 5.0}) {
    // Fifty solves with a relative tolerance of 1e-11 each.
    EXPECT_LT(recurrence_error(time, big_omega, newmark_cosine(big_omega, 0.25)), 1e-9);
  }
}

TEST(Period, CentralDifferenceIsBetaZero) {
  TimeParameters time;
  time.method = TimeMethod::explicit_newmark;
  for (const double big_omega : {0.1, 0.5, 1.0, 1.5, 1.9}) {
    // No solver: round-off only.
    EXPECT_LT(recurrence_error(time, big_omega, newmark_cosine(big_omega, 0)), 1e-12);
  }
}

TEST(Period, GeneralisedAlphaWithRhoOneIsAverageAcceleration) {
  TimeParameters time;
  time.scheme = ImplicitScheme::generalised_alpha;
  time.rho_infinity = 1;
  EXPECT_LT(recurrence_error(time, 1, newmark_cosine(1, 0.25)), 1e-9);
}

// No recurrence of three terms: backward Euler in (u, v) has the roots 1/(1 +- i W).
TEST(Period, BackwardEulerLengthensThePeriodByItsOwnFormula) {
  TimeParameters time;
  Oscillator oscillator(time);
  const double omega = oscillator.omega();
  const double big_omega = 0.2;
  oscillator.set({1, 0, 0});
  std::vector<double> u{1};
  for (int n = 0; n < 20; ++n) {
    oscillator.step(big_omega / omega);
    u.push_back(oscillator.get()[0]);
  }
  const double square = 1 + big_omega * big_omega;
  for (std::size_t n = 1; n + 1 < u.size(); ++n) {
    EXPECT_NEAR(square * u[n + 1] - 2 * u[n] + u[n - 1], 0, 1e-9);
  }
}

}  // namespace
}  // namespace stylet
