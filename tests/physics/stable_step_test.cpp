// The stable step of central differences, from the true largest eigenvalue of a small body.
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/implicit_newmark.hpp"

#include "support/modes.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

Body small_body(std::optional<RayleighDamping> damping) {
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
  Body body = small_body(damping);
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

// Square roots of the bound over the true eigenvalue: how much too strict the step is.
double strictness(Plane plane, double jitter) {
  const Body body(
      rectangle({.width = 0.08, .height = 0.06, .columns = 8, .rows = 6, .jitter = jitter}),
      material({60e3, 0.45, 1000}, plane, MassKind::lumped, 0.01));
  double bound = 0;
  for (int c = 0; c < body.mesh.n_cells(); ++c) {
    bound = std::max(bound, body.tissue.element_bound(body.mesh, c));
  }
  return std::sqrt(bound / dense_modes(body.tissue, {}).squares.back());
}

TEST(StableStep, ElementBoundIsAboveTheTrueEigenvalue) {
  for (const Plane plane : {Plane::stress, Plane::strain}) {
    EXPECT_GE(strictness(plane, 0), 1);
    EXPECT_GE(strictness(plane, 0.2), 1);
    // A bound far off would make interactive runs slow. Nodes that many alike triangles share have
    // about twice a third of their mass.
    EXPECT_LE(strictness(plane, 0), 1.8);
    EXPECT_LE(strictness(plane, 0.2), 2.5);
  }
}

TEST(StableStep, ElementBoundIsTheElementsLargestEigenvalueWithinSevenPerCent) {
  const Grid grid{.width = 0.04, .height = 0.03, .columns = 2, .rows = 2, .jitter = 0.25};
  const MeshData data = rectangle(grid);
  const auto parameters = material({60e3, 0.45, 1000}, Plane::strain, MassKind::lumped, 0.01);
  for (std::size_t c = 0; c < 8; ++c) {
    MeshData one;
    one.source = "one triangle";
    one.region_names = {"tissue"};
    one.cell_region = {0};
    one.cells = {0, 1, 2};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto node = static_cast<std::size_t>(data.cells[3 * c + i]);
      one.coordinates.push_back(data.coordinates[2 * node]);
      one.coordinates.push_back(data.coordinates[2 * node + 1]);
    }
    const Body body(one, parameters);
    const double exact = dense_modes(body.tissue, {}).squares.back();
    const double ratio = body.tissue.element_bound(body.mesh, 0) / exact;
    EXPECT_GE(ratio, 1 - 1e-12);
    // The sum of three equal 16th powers: 3^(1/16).
    EXPECT_LE(ratio, std::pow(3.0, 1.0 / 16) + 1e-12);
  }
}

}  // namespace
}  // namespace stylet
