// Spectral radius of a step, from the amplification matrix of (u, h v, h^2 a) that the integrator
// itself yields when it starts from unit states.
#include "support/oscillator.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

template <std::size_t N>
using Matrix = std::array<std::array<double, N>, N>;

// lim |A^n|^(1/n) with n = 2^40, by squaring.
template <std::size_t N>
double spectral_radius(Matrix<N> a) {
  double log_radius = 0;
  double power = 1;
  for (int squaring = 0; squaring < 40; ++squaring) {
    double size = 0;
    for (const auto& row : a) {
      for (const double value : row) size = std::max(size, std::abs(value));
    }
    if (size == 0) return 0;
    log_radius += std::log(size) / power;
    power *= 2;
    Matrix<N> square{};
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) {
        for (std::size_t k = 0; k < N; ++k) square[i][j] += a[i][k] / size * (a[k][j] / size);
      }
    }
    a = square;
  }
  return std::exp(log_radius);
}

TimeParameters implicit(ImplicitScheme scheme, double rho_infinity = 1) {
  TimeParameters time;
  time.scheme = scheme;
  time.rho_infinity = rho_infinity;
  return time;
}

// big_omega: omega times h.
Matrix<3> amplification(const TimeParameters& time, double big_omega) {
  Oscillator oscillator(time);
  const double h = big_omega / oscillator.omega();
  const std::array<double, 3> scale{1, h, h * h};
  Matrix<3> a{};
  for (std::size_t column = 0; column < 3; ++column) {
    Oscillator::Values unit{};
    unit[column] = 1 / scale[column];
    oscillator.set(unit);
    oscillator.step(h);
    const auto end = oscillator.get();
    for (std::size_t row = 0; row < 3; ++row) a[row][column] = end[row] * scale[row];
  }
  return a;
}

// The paper read literally, for (u, h v, h^2 a): its linear system for a1, then
// u1 = u0 + h v1 + h^2/4 (a0 + a1) with the new velocity v1 = v0 + h/2 (a0 + a1).
Matrix<3> misprint(double big_omega) {
  const double square = big_omega * big_omega;
  const double pull = -square / (1 + square / 4);
  const std::array<double, 3> a{pull, pull, pull / 4};
  const std::array<double, 3> v{a[0] / 2, 1 + a[1] / 2, 0.5 + a[2] / 2};
  const std::array<double, 3> u{1 + v[0] + a[0] / 4, v[1] + a[1] / 4, v[2] + 0.25 + a[2] / 4};
  return {u, v, a};
}

const std::vector<double> steps{0.01, 0.1, 0.5, 1, 1.15, 1.16, 1.5, 2, 3, 10, 100, 1e3};

TEST(SpectralRadius, AverageAccelerationNeitherGrowsNorDecays) {
  for (const double big_omega : steps) {
    const double radius =
        spectral_radius(amplification(implicit(ImplicitScheme::average_acceleration), big_omega));
    // The solver's relative tolerance is 1e-11.
    EXPECT_NEAR(radius, 1, 1e-9) << "omega h = " << big_omega;
  }
}

TEST(SpectralRadius, BackwardEulerIsTheClosedForm) {
  for (const double big_omega : steps) {
    const double radius =
        spectral_radius(amplification(implicit(ImplicitScheme::backward_euler), big_omega));
    const double exact = 1 / std::sqrt(1 + big_omega * big_omega);
    EXPECT_NEAR(radius, exact, 1e-9 * exact) << "omega h = " << big_omega;
  }
}

TEST(SpectralRadius, GeneralisedAlphaReachesRhoInfinity) {
  for (const double rho : {0.0, 0.3, 0.5, 0.8, 0.9, 1.0}) {
    const auto time = implicit(ImplicitScheme::generalised_alpha, rho);
    // A double (at rho = 0 triple) root splits like 1/(omega h), and round-off of the step like its
    // square or cube root: 1e-5 or 1e-4 for the solver's 1e-11.
    constexpr double stiff = 1e5;
    EXPECT_NEAR(spectral_radius(amplification(time, stiff)), rho, 1e-3) << "rho = " << rho;
    // Never unstable, and monotone on the way.
    double last = 1 + 1e-9;
    for (const double big_omega : steps) {
      const double radius = spectral_radius(amplification(time, big_omega));
      EXPECT_LE(radius, last + 1e-9) << "rho = " << rho << ", omega h = " << big_omega;
      last = radius;
    }
  }
}

TEST(SpectralRadius, MisprintOfThePaperWouldBeUnstable) {
  const double limit = 2 / std::sqrt(3.0);
  // The radius passes 1 at the limit with a slope of 0.6 in relative steps.
  EXPECT_LT(spectral_radius(misprint(0.999 * limit)), 0.9995);
  EXPECT_GT(spectral_radius(misprint(1.001 * limit)), 1.0005);
  for (const double factor : {1.001, 1.1, 2.0}) {
    const double ours = spectral_radius(
        amplification(implicit(ImplicitScheme::average_acceleration), factor * limit));
    // The integrator is off by its solver's round-off only, far less than the misprint.
    EXPECT_GT(spectral_radius(misprint(factor * limit)) - ours, 5e-4);
  }
  // Below the limit it would damp, which average acceleration does not.
  EXPECT_LT(spectral_radius(misprint(0.5)), 0.9);
}

}  // namespace
}  // namespace stylet
