// The stable step of central differences, from the true largest eigenvalue of a small body.
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/implicit_newmark.hpp"

#include "support/modes.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

Slab small_body(std::optional<RayleighDamping> damping) {
  auto p = material({60e3, 0.45, 1000}, Plane::stress, MassKind::lumped, 0.01);
  p.damping = damping;
  return {rectangle({.width = 0.04, .height = 0.03, .columns = 4, .rows = 3, .jitter = 0.2}), p};
}

TimeParameters central_difference() {
  TimeParameters time;
  time.method = TimeMethod::explicit_newmark;
  return time;
}

/// Free vibration from the stiffest mode with a step that is `factor` times `limit(omega)`.
template <class Limit>
double amplitude_after(std::optional<RayleighDamping> damping,
                       Limit&& limit,
                       double factor,
                       int steps) {
  Slab body = small_body(damping);
  const auto supports = dofs_of(body.mesh, {"left"});
  const auto modes = dense_modes(body.tissue, supports);
  ExplicitNewmark integrator(body.tissue, body.mesh, central_difference());
  State state = still(body.tissue);
  state.u = vector_of(body.tissue, modes.shapes.back());
  const double size = largest(modes.shapes.back());
  OwnedVec load = body.tissue.make_vector();
  check(VecSet(load.get(), 0));
  const auto constraints = held(supports);
  initial_acceleration(body.tissue, state, load.get(), constraints);
  const double h = factor * limit(std::sqrt(modes.squares.back()));
  double amplitude = 0;
  for (int n = 0; n < steps && amplitude < 1e20; ++n) {
    step(integrator, state, load.get(), h, constraints);
    PetscReal now = 0;
    check(VecNorm(state.u.get(), NORM_INFINITY, &now));
    if (n >= steps / 2) amplitude = std::max(amplitude, now / size);
  }
  return amplitude;
}

double two_over_omega(double omega) {
  return 2 / omega;
}

// At W = omega h = 2 (1 -+ d) the growth a step is acosh(W^2/2 - 1) = 4 sqrt(d), so 1000 steps at
// d = 1e-3 grow by e^126; below, beats reach 1/sqrt(1 - W^2/4) = 22 at most.
TEST(StableStep, IsTwoOverOmegaWithoutDamping) {
  EXPECT_LT(amplitude_after({}, two_over_omega, 0.999, 2000), 23);
  EXPECT_GT(amplitude_after({}, two_over_omega, 1.001, 2000), 1e10);
}

// Mass damping is implicit on the diagonal and leaves the limit where it is: the roots of
// (1 + c) z^2 - (2 - W^2) z + (1 - c) = 0, c = h mass_factor / 2, pass -1 at W = 2. The growth a step
// is about 2 d W / (2 c) beyond it.
TEST(StableStep, IsTwoOverOmegaWithMassDamping) {
  const auto omega = std::sqrt(
      dense_modes(small_body({}).tissue, dofs_of(small_body({}).mesh, {"left"})).squares.back());
  const RayleighDamping damping{0.2 * omega, 0};
  EXPECT_LT(amplitude_after(damping, two_over_omega, 0.999, 10000), 1e-3);
  EXPECT_GT(amplitude_after(damping, two_over_omega, 1.001, 10000), 1e3);
}

// Stiffness damping acts at the old half-step velocity: W = 2 (sqrt(1 + xi^2) - xi).
TEST(StableStep, ShrinksWithStiffnessDampingAsInClosedForm) {
  const auto omega = std::sqrt(
      dense_modes(small_body({}).tissue, dofs_of(small_body({}).mesh, {"left"})).squares.back());
  for (const double xi : {0.05, 0.3, 1.0}) {
    const RayleighDamping damping{0, 2 * xi / omega};
    const auto limit = [&](double w) { return 2 * (std::sqrt(1 + xi * xi) - xi) / w; };
    EXPECT_NEAR(stable_step(omega * omega, damping.stiffness_factor), limit(omega),
                1e-12 * limit(omega));
    EXPECT_LT(amplitude_after(damping, limit, 0.999, 20000), 1e-3) << "xi = " << xi;
    EXPECT_GT(amplitude_after(damping, limit, 1.001, 20000), 1e3) << "xi = " << xi;
  }
}

// The true limit over the predicted step: how much too strict that is.
double strictness(Plane plane, Formulation formulation, double jitter) {
  auto p = material({60e3, 0.45, 1000}, plane, MassKind::lumped, 0.01);
  p.formulation = formulation;
  Slab body(rectangle({.width = 0.08, .height = 0.06, .columns = 8, .rows = 6, .jitter = jitter}),
            p);
  TimeParameters time = central_difference();
  time.safety = 1;
  const ExplicitNewmark integrator(body.tissue, body.mesh, time);
  return 2 / std::sqrt(dense_modes(body.tissue, {}).squares.back()) / integrator.stable_step();
}

TEST(StableStep, BoundIsAboveTheTrueEigenvalue) {
  for (const Plane plane : {Plane::stress, Plane::strain}) {
    for (const Formulation formulation : {Formulation::p1, Formulation::p1_averaged}) {
      for (const double jitter : {0.0, 0.2}) {
        const double times = strictness(plane, formulation, jitter);
        EXPECT_GE(times, 1);
        // A bound far off would make interactive runs slow: row sums alone give up to 1.5.
        EXPECT_LE(times, 1.2);
      }
    }
  }
}

// Moved nodes: still safe, not far off, and as before once they are back.
TEST(StableStep, FollowsEdits) {
  auto p = material({60e3, 0.45, 1000}, Plane::stress, MassKind::lumped, 0.01);
  Slab body(rectangle({.width = 0.08, .height = 0.06, .columns = 8, .rows = 6, .jitter = 0.1}), p);
  TimeParameters time = central_difference();
  time.safety = 1;
  ExplicitNewmark integrator(body.tissue, body.mesh, time);
  const double before = integrator.stable_step();
  int inner = 0;
  while (body.mesh.on_boundary(inner)) ++inner;
  const ReferencePoint from = body.mesh.point(inner);
  for (const double shift : {2e-3, 4e-3, 1e-3, 0.0}) {
    body.mesh.move_node(inner, {from.x + shift, from.y});
    const auto around = body.mesh.cells_around(inner);
    body.tissue.update(body.mesh, around);
    integrator.touched(body.mesh, around);
    const double limit = 2 / std::sqrt(dense_modes(body.tissue, {}).squares.back());
    EXPECT_LE(integrator.stable_step(), limit) << shift;
    EXPECT_GE(integrator.stable_step(), 0.7 * limit) << shift;
    if (shift == 4e-3) {
      EXPECT_LT(integrator.stable_step(), before);
    }
  }
  EXPECT_DOUBLE_EQ(integrator.stable_step(), before);
}

}  // namespace
}  // namespace stylet
