// Friction that grows with the speed of sliding, as it is reported and as it reaches the tissue.
#include "support/block.hpp"
#include "support/scenes.hpp"
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace stylet {
namespace {

constexpr double kinetic = 130;      // N/m
constexpr double viscous = 2000;     // N s/m^2
constexpr double tip_length = 6e-3;  // m

// Tissue that hardly moves, so that it slides by the needle's own speed.
const std::string rigid = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 16, rows: 12}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 6e13 Pa, poisson_ratio: 0.3, density: 1000 kg/m^3}}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 3.1 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s, viscous_coefficient: 2000 N s/m^2}
    motion:
      - insert: {speed: 2 cm/s, depth: 3 cm}
      - insert: {speed: 5 cm/s, depth: 5 cm}
      - retract: {speed: 4 cm/s, depth: 2 cm}
time: {method: quasi_static, step: 20 ms}
)";

void expect_closed_form(const std::vector<std::string>& overrides) {
  Simulation simulation(MPI_COMM_WORLD, scene_of(rigid, overrides), false);
  const auto supports = dofs_of(simulation.mesh(), {"left", "top", "bottom"});
  std::optional<double> from;
  int n_in = 0;
  int n_out = 0;
  double work = 0;
  double dissipated = 0;
  run_to_end(simulation, [&](const StepRecord& record) {
    const Needle& needle = *simulation.needle();
    const double start = from.value_or(needle.skin());
    from = needle.tip();
    const double speed = (needle.tip() - start) / record.h;
    // Going back, the shaft is what is in at the start of the step.
    const double in = speed > 0 ? needle.path_length() : start - needle.skin();
    const double per_metre = std::copysign(kinetic, speed) + viscous * speed;
    const double friction = per_metre * std::max(0.0, in - tip_length);
    // A cut stops within 1e-4 of the needle's way in a step, 1 mm at most; times 230 N/m, of 10 N.
    constexpr double tolerance = 3e-5;
    EXPECT_NEAR(record.needle.forces.friction, friction, tolerance) << needle.tip() - needle.skin();
    ++(speed > 0 ? n_in : n_out);
    const auto force = stiffness_forces(simulation.tissue(), simulation.state().u.get());
    double along = 0;
    for (const int dof : supports) {
      if (dof % 2 == Axis::along_component) along += force[static_cast<std::size_t>(dof)];
    }
    EXPECT_NEAR(along, record.needle.forces.total(), tolerance);
    work += record.needle.work;
    dissipated += record.needle.dissipated;
  });
  EXPECT_GT(n_in, 50);
  EXPECT_GT(n_out, 30);
  EXPECT_GT(work, 0.1);
  EXPECT_NEAR(dissipated, work, 1e-6 * work);
}

TEST(ViscousFriction, OfANeedleThroughTissueAtRest) {
  expect_closed_form({});
  expect_closed_form({"time.step=7 ms"});
}

/// m u'' + c l u' + k u = (mu + c V) l from rest, mu the kinetic force a metre.
double closed_form(const Block& block, const FrictionParameters& law, double t) {
  const double c = law.viscous_coefficient * block.length();
  const double ratio = c / (2 * block.m() * block.omega());
  const double damped = block.omega() * std::sqrt(1 - ratio * ratio);
  const double decay = ratio * block.omega();
  const double rest = (block.kinetic_force() + c * dragging::speed) / block.k();
  return rest * (1 - std::exp(-decay * t) *
                         (std::cos(damped * t) + decay / damped * std::sin(damped * t)));
}

double error_of_block(const TimeParameters& time, double angle) {
  // Hardly any dry friction, so that the block slides from the start.
  FrictionParameters law{1e-3, 1e-3, 1e-9, 1e-8};
  {
    const Block block(time, law);
    law.viscous_coefficient = 0.6 * block.omega() * block.m() / block.length();
  }
  Block block(time, law);
  const double h = angle / block.omega();
  const int n = static_cast<int>(std::lround(3 / angle));
  for (int i = 0; i < n; ++i) {
    block.step(h);
    EXPECT_FALSE(block.sticks());
  }
  const double rest = law.viscous_coefficient * block.length() * dragging::speed / block.k();
  return (block.u() - closed_form(block, law, n * h)) / rest;
}

TEST(ViscousFriction, DragsABlockByTheClosedForm) {
  const TimeParameters implicit;
  const double coarse = error_of_block(implicit, 0.02);
  const double fine = error_of_block(implicit, 0.01);
  EXPECT_LT(std::abs(fine), 0.01);
  EXPECT_NEAR(order(std::abs(coarse), std::abs(fine)), 1, 0.1);
  TimeParameters central;
  central.method = TimeMethod::explicit_newmark;
  // Its first half step is without the force that begins.
  EXPECT_LT(std::abs(error_of_block(central, 0.01)), 0.01);
}

}  // namespace
}  // namespace stylet
