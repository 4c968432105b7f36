// A standing shear wave in a box on rollers, in space and time at once: implicit and explicit steps go
// to the same known answer, and to each other on one mesh.
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/implicit_newmark.hpp"

#include "support/body.hpp"
#include <gtest/gtest.h>

#include <memory>
#include <numbers>

namespace stylet {
namespace {

constexpr double pi = std::numbers::pi;
constexpr LinearElastic elastic{1, 0.3, 1};

double omega() {
  return std::sqrt(elastic.youngs_modulus / (2 * 1.3) * 2) * pi;
}

// Divergence-free; normal displacement and shear vanish on the sides.
Vector2 shape(ReferencePoint p) {
  return {std::sin(pi * p.x) * std::cos(pi * p.y), -std::cos(pi * p.x) * std::sin(pi * p.y)};
}

ConstraintSet rollers(const Mesh& mesh) {
  std::vector<int> dofs;
  for (const char* side : {"left", "right"}) {
    for (const int node : mesh.nodes_of(side)) dofs.push_back(2 * node);
  }
  for (const char* side : {"bottom", "top"}) {
    for (const int node : mesh.nodes_of(side)) dofs.push_back(2 * node + 1);
  }
  return held(dofs);
}

struct Wave {
  std::vector<double> u;  ///< at the end
  double error = 0;       ///< largest in time of the L2 norm, relative
};

double mass_norm(const TissueOperator& tissue, Vec x) {
  OwnedVec y = tissue.make_vector();
  tissue.apply_mass(x, y.get());
  PetscScalar square = 0;
  check(VecDot(x, y.get(), &square));
  return std::sqrt(square);
}

// On n x n squares, from rest in the shape of the mode, over `end` seconds.
Wave wave(int n, int steps, double end, TimeMethod method, MassKind mass) {
  Slab body(rectangle({.columns = n, .rows = n}), material(elastic, Plane::strain, mass));
  TimeParameters time;
  time.method = method;
  time.scheme = ImplicitScheme::average_acceleration;
  std::unique_ptr<TimeIntegrator> integrator;
  if (method == TimeMethod::explicit_newmark) {
    integrator = std::make_unique<ExplicitNewmark>(body.tissue, body.mesh, time);
  } else {
    integrator = std::make_unique<ImplicitNewmark>(body.tissue, time);
  }
  State state = still(body.tissue);
  state.u = nodal(body.tissue, body.mesh, shape);
  OwnedVec load = body.tissue.make_vector();
  check(VecSet(load.get(), 0));
  const ConstraintSet constraints = rollers(body.mesh);
  initial_acceleration(body.tissue, state, load.get(), constraints);
  const OwnedVec mode = nodal(body.tissue, body.mesh, shape);
  OwnedVec off = body.tissue.make_vector();
  Wave result;
  for (int i = 1; i <= steps; ++i) {
    step(*integrator, state, load.get(), end / steps, constraints);
    check(VecWAXPY(off.get(), -std::cos(omega() * end * i / steps), mode.get(), state.u.get()));
    result.error = std::max(result.error,
                            mass_norm(body.tissue, off.get()) / mass_norm(body.tissue, mode.get()));
  }
  result.u = gather_all(state.u.get());
  return result;
}

double difference(const Wave& a, const Wave& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.u.size(); ++i) worst = std::max(worst, std::abs(a.u[i] - b.u[i]));
  return worst;
}

double end() {
  return 1.3 * 2 * pi / omega();
}

TEST(StandingWave, ImplicitConvergesWithOrderTwoInSpaceAndTime) {
  // Eight steps a square: with two the errors of mesh and step nearly cancel, since one raises the
  // frequency and the other lowers it.
  const auto error = [](int n) {
    return wave(n, 8 * n, end(), TimeMethod::implicit_newmark, MassKind::consistent).error;
  };
  const double coarse = error(16);
  const double fine = error(32);
  RecordProperty("order", std::to_string(order(coarse, fine)));
  RecordProperty("error", std::to_string(fine));
  EXPECT_NEAR(order(coarse, fine), 2, 0.1);
  EXPECT_LT(fine, 0.02);  // 1.4 per mille of the frequency times 8.2 rad
}

TEST(StandingWave, ExplicitConvergesWithOrderTwoInSpaceAndTime) {
  // Sixteen steps a square are stable: omega_max h < 2.
  const auto error = [](int n) {
    return wave(n, 16 * n, end(), TimeMethod::explicit_newmark, MassKind::lumped).error;
  };
  const double coarse = error(16);
  const double fine = error(32);
  RecordProperty("order", std::to_string(order(coarse, fine)));
  RecordProperty("error", std::to_string(fine));
  EXPECT_NEAR(order(coarse, fine), 2, 0.1);
  EXPECT_LT(fine, 0.02);
}

TEST(StandingWave, ImplicitAndExplicitMeetOnOneMesh) {
  const auto apart = [](int steps) {
    return difference(wave(8, steps, end(), TimeMethod::explicit_newmark, MassKind::lumped),
                      wave(8, steps, end(), TimeMethod::implicit_newmark, MassKind::lumped));
  };
  const double coarse = apart(800);
  const double fine = apart(1600);
  RecordProperty("order", std::to_string(order(coarse, fine)));
  RecordProperty("apart", std::to_string(fine));
  // Both are of order two in time, so they meet with order two.
  EXPECT_NEAR(order(coarse, fine), 2, 0.05);
  EXPECT_LT(fine, 1e-3);  // of an amplitude of 1
}

}  // namespace
}  // namespace stylet
