// Dashpots of the integrators: one mass on a spring against closed forms, and the balance of forces at the
// end of a step where a dashpot, a mean condition and mass damping meet at one node.
#include "support/oscillator.hpp"
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace stylet {
namespace {

TimeParameters time_of(TimeMethod method, ImplicitScheme scheme = ImplicitScheme::backward_euler) {
  TimeParameters time;
  time.method = method;
  time.scheme = scheme;
  return time;
}

// m u'' + c (u' - V) + k u = 0 from rest, with a damping ratio of 0.3.
double error_of_dragged_mass(const TimeParameters& time, int n_steps) {
  Oscillator oscillator(time);
  const double omega = oscillator.omega();
  constexpr double ratio = 0.3;
  constexpr double speed = 0.2;
  const double c = 2 * ratio * omega * oscillator.mass();
  oscillator.drag(c, speed);
  oscillator.set({0, 0, c * speed / oscillator.mass()});
  const double end = 4 / omega;
  for (int n = 0; n < n_steps; ++n) oscillator.step(end / n_steps);
  const double damped = omega * std::sqrt(1 - ratio * ratio);
  const double rest = c * speed / (omega * omega * oscillator.mass());
  const double exact =
      rest * (1 - std::exp(-ratio * omega * end) *
                      (std::cos(damped * end) + ratio * omega / damped * std::sin(damped * end)));
  return std::abs(oscillator.get()[0] - exact) / rest;
}

void expect_order(const TimeParameters& time, double expected, double largest) {
  const double coarse = error_of_dragged_mass(time, 128);
  const double fine = error_of_dragged_mass(time, 256);
  EXPECT_LT(fine, largest);
  EXPECT_NEAR(order(coarse, fine), expected, 0.1);
}

TEST(Dashpot, DragsAMassByTheClosedForm) {
  expect_order(time_of(TimeMethod::implicit_newmark), 1, 1e-2);
  expect_order(time_of(TimeMethod::implicit_newmark, ImplicitScheme::average_acceleration), 2,
               1e-4);
  expect_order(time_of(TimeMethod::implicit_newmark, ImplicitScheme::generalised_alpha), 2, 1e-3);
  expect_order(time_of(TimeMethod::explicit_newmark), 2, 1e-4);
}

// Without inertia c (V - u') = k u: the time constant is c/k.
TEST(Dashpot, RelaxesWithoutInertia) {
  const auto error = [](int n_steps) {
    Oscillator oscillator(time_of(TimeMethod::quasi_static));
    const double k = oscillator.mass() * oscillator.omega() * oscillator.omega();
    constexpr double speed = 0.2;
    constexpr double constant = 0.3;  // s
    oscillator.drag(constant * k, speed);
    const double end = 2 * constant;
    for (int n = 0; n < n_steps; ++n) oscillator.step(end / n_steps);
    return std::abs(oscillator.get()[0] / (constant * speed) - (1 - std::exp(-2.0)));
  };
  const double fine = error(256);
  EXPECT_LT(fine, 2e-3);
  EXPECT_NEAR(order(error(128), fine), 1, 0.05);
}

// However strong: explicit steps do not have to be shorter, and the mass goes with what drags it.
TEST(Dashpot, HoldsHoweverStrong) {
  for (const TimeMethod method : {TimeMethod::explicit_newmark, TimeMethod::implicit_newmark}) {
    Oscillator oscillator(time_of(method));
    oscillator.drag(1e9 * oscillator.omega() * oscillator.mass(), 0.2);
    for (int n = 0; n < 10; ++n) oscillator.step(0.1 / oscillator.omega());
    EXPECT_NEAR(oscillator.get()[1], 0.2, 1e-8);
  }
}

void expect_balance(TimeMethod method) {
  const bool is_explicit = method == TimeMethod::explicit_newmark;
  auto parameters = material({1, 0.3, 1}, Plane::stress, MassKind::lumped);
  parameters.damping = RayleighDamping{.mass_factor = 0.4};
  Slab body(rectangle({.columns = 4, .rows = 4}), parameters);
  std::vector<int> inner;
  for (int node = 0; node < body.mesh.n_nodes(); ++node) {
    if (!body.mesh.on_boundary(node)) inner.push_back(2 * node);
  }
  const ConstraintSet supports = held(dofs_of(body.mesh, {"left"}));
  ConstraintSet constraints;
  constraints.mean = MeanCondition{{{inner[0], 0.25}, {inner[1], 0.75}}, 0, 0.01, true};
  constraints.forces = {{inner[2], 0.02}};
  constraints.dashpots = {{inner[1], 3, 0.02}, {inner[2], 5, -0.03}, {inner[3], 2, 0.01}};
  OwnedVec load = body.tissue.make_vector();
  check(VecSet(load.get(), 0));
  State state = still(body.tissue);
  const TimeParameters time = time_of(method);
  std::unique_ptr<TimeIntegrator> integrator;
  if (is_explicit) {
    integrator = std::make_unique<ExplicitNewmark>(body.tissue, body.mesh, time);
  } else {
    integrator = std::make_unique<ImplicitNewmark>(body.tissue, body.mesh, time);
  }
  const double h = 0.02;
  for (int n = 0; n < 5; ++n) {
    constraints.mean->value += 0.01 * h;
    integrator->begin(state, load.get(), h, supports.dofs);
    static_cast<void>(integrator->attempt(constraints, false));
    const Trial trial = integrator->finish(true);
    const double lambda = is_explicit ? trial.settled.lambda : trial.needed.lambda;
    integrator->accept();
    auto left = stiffness_forces(body.tissue, state.u.get());
    const auto v = gather_all(state.v.get());
    const auto a = gather_all(state.a.get());
    const auto m = gather_all(body.tissue.lumped_mass());
    const double size = largest(left);
    for (std::size_t i = 0; i < left.size(); ++i) left[i] += m[i] * (a[i] + 0.4 * v[i]);
    const auto at = [](auto& values, int dof) -> auto& {
      return values[static_cast<std::size_t>(dof)];
    };
    double rate = 0;
    for (const auto& [dof, weight] : constraints.mean->weights) {
      at(left, dof) -= lambda * weight;
      rate += weight * at(v, dof);
    }
    for (const auto& [dof, force] : constraints.forces) at(left, dof) -= force;
    for (const auto& [dof, c, speed] : constraints.dashpots) {
      at(left, dof) -= c * (speed - at(v, dof));
    }
    for (const auto& c : supports.dofs) at(left, c.dof) = 0;
    EXPECT_NEAR(rate, 0.01, 1e-14);
    EXPECT_LT(largest(left), 1e-11 * (size + 0.1));  // round-off
  }
}

TEST(Dashpot, ForcesBalanceWhereItMeetsTheTip) {
  expect_balance(TimeMethod::explicit_newmark);
  expect_balance(TimeMethod::implicit_newmark);
}

}  // namespace
}  // namespace stylet
