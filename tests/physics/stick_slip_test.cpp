// Coulomb friction on a dragged block gives saw-teeth of known height and length.
#include "support/block.hpp"
#include <gtest/gtest.h>

#include <string>

namespace stylet {
namespace {

struct Cycle {
  double force_at_slip = 0;
  double force_after_slip = 0;
  double stick_time = 0;
};

// The block starts at rest under a moving needle, so it slips for a moment, sticks until the static
// limit, slips, and sticks again: that is the periodic cycle.
Cycle first_cycle(Block& block_, double h) {
  Cycle cycle;
  constexpr int most = 200000;
  int n = 0;
  const auto advance_while = [&](bool sticking) {
    const int start = n;
    for (; n < most && block_.sticks() == sticking; ++n) {
      if (sticking) cycle.force_at_slip = block_.spring_force();
      block_.step(h);
    }
    return (n - start) * h;
  };
  advance_while(true);
  advance_while(false);
  advance_while(true);
  advance_while(false);
  cycle.force_after_slip = block_.spring_force();
  cycle.stick_time = advance_while(true);
  EXPECT_LT(n, most);
  return cycle;
}

// angle: omega h. share: tolerance in units of 2 (F_s - F_k), of which numerical damping eats
// a part during the half period of a slip.
void expect_saw_teeth(const TimeParameters& time, double angle, double share) {
  // A stick speed below what one step changes the velocity by, or a block that starts to slip sticks again.
  Block block_(time, {195, 130, 1e-4, 1e-3});
  const double h = angle / block_.omega();
  const Cycle cycle = first_cycle(block_, h);
  const double fs = block_.static_force();
  const double fk = block_.kinetic_force();
  const double drop = 2 * (fs - fk);
  const double stick_time = drop / (block_.k() * dragging::speed);
  EXPECT_NEAR(cycle.force_at_slip, fs, share * drop);
  EXPECT_NEAR(cycle.force_after_slip, 2 * fk - fs, share * drop);
  EXPECT_NEAR(cycle.stick_time, stick_time, share * stick_time);
  testing::Test::RecordProperty("force_at_slip", std::to_string(cycle.force_at_slip / fs));
  testing::Test::RecordProperty("force_after_slip",
                                std::to_string(cycle.force_after_slip / (2 * fk - fs)));
  testing::Test::RecordProperty("stick_time", std::to_string(cycle.stick_time / stick_time));
}

TEST(StickSlip, BackwardEulerGivesTheClosedForm) {
  // Amplitudes shrink by exp(-pi angle / 2) in the slip, 0.8 % here.
  expect_saw_teeth({}, 0.005, 0.01);
}

TEST(StickSlip, GeneralisedAlphaGivesTheClosedForm) {
  TimeParameters time;
  time.scheme = ImplicitScheme::generalised_alpha;
  expect_saw_teeth(time, 0.005, 0.01);
}

TEST(StickSlip, CentralDifferenceGivesTheClosedForm) {
  TimeParameters time;
  time.method = TimeMethod::explicit_newmark;
  expect_saw_teeth(time, 0.005, 0.01);
}

// A node that begins to stick with acceleration a would keep the reaction m a, of the size of
// F_s - F_k, with alternating sign for ever, and slip too early, were it not for the damped start.
TEST(StickSlip, AverageAccelerationGivesTheClosedForm) {
  TimeParameters time;
  time.scheme = ImplicitScheme::average_acceleration;
  expect_saw_teeth(time, 0.005, 0.01);
}

}  // namespace
}  // namespace stylet
