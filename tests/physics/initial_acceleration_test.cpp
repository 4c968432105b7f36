// Loads that act from t = 0 accelerate the tissue at once: M a = f in the first step.
#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/simulation/conditions.hpp"

#include "support/body.hpp"
#include "support/scenes.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

const std::string pulled = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 8, rows: 6, jitter: 0.1}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}}
supports: {left: fixed}
loads: {traction: [{curve: right, force: [6 N/m, 2 N/m]}]}
time: {scheme: average_acceleration, step: 1 us, duration: 1 us}
)";

class InitialAcceleration : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Mass, InitialAcceleration, testing::Values("consistent", "lumped"));

TEST_P(InitialAcceleration, BalancesTheTractionAtFreeNodes) {
  const Scene scene = scene_of(pulled, {"tissue.mass=" + GetParam()});
  Simulation simulation(MPI_COMM_WORLD, scene, false);
  const Mesh& mesh = simulation.mesh();
  const TissueOperator& tissue = simulation.tissue();
  const auto force = Conditions(scene, mesh).load(mesh, 0);
  const OwnedVec load = vector_of(tissue, force);
  const auto supports = dofs_of(mesh, {"left"});
  State state = still(tissue);
  initial_acceleration(tissue, state, load.get(), held(supports));
  OwnedVec inertia = tissue.make_vector();
  tissue.apply_mass(state.a.get(), inertia.get());
  const auto ma = gather_all(inertia.get());
  const auto a = gather_all(state.a.get());
  const double size = largest(force);
  EXPECT_NEAR(size, 0.06, 1e-12);  // 6 N/m over one edge of 1 cm
  for (const int dof : supports) EXPECT_EQ(a[static_cast<std::size_t>(dof)], 0);
  for (const int dof : others(tissue, supports)) {
    const auto i = static_cast<std::size_t>(dof);
    EXPECT_NEAR(ma[i], force[i], 1e-10 * size);  // the solver's relative tolerance is 1e-11
  }
  EXPECT_GT(largest(a), 0.1);
}

TEST_P(InitialAcceleration, MovesTheTissueInTheFirstStep) {
  const Scene scene = scene_of(pulled, {"tissue.mass=" + GetParam()});
  Simulation simulation(MPI_COMM_WORLD, scene, false);
  const OwnedVec load = vector_of(simulation.tissue(),
                                  Conditions(scene, simulation.mesh()).load(simulation.mesh(), 0));
  State state = still(simulation.tissue());
  initial_acceleration(simulation.tissue(), state, load.get(),
                       held(dofs_of(simulation.mesh(), {"left"})));
  simulation.step();
  const auto a = gather_all(state.a.get());
  const auto u = gather_all(simulation.state().u.get());
  const double h = scene.time.step;
  const double scale = 0.5 * h * h * largest(a);
  // Without a0 it would be half of it; elastic forces change it by (omega h)^2, 1e-5 here.
  for (std::size_t i = 0; i < u.size(); ++i) EXPECT_NEAR(u[i], 0.5 * h * h * a[i], 1e-4 * scale);
}

}  // namespace
}  // namespace stylet
