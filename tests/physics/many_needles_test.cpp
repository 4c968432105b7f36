// One needle after another: what one has done to the mesh is not there for the next.
#include "support/scenes.hpp"
#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace stylet {
namespace {

const char* const tissue = R"(
mesh:
  rectangle:
    size: [8 cm, 6 cm]
    columns: 16
    rows: 12
    region: tissue
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.4, density: 1000 kg/m^3}}
supports: {left: fixed, top: fixed, bottom: fixed}
targets: {seed: [4 cm, 3.2 cm]}
time: {method: quasi_static, step: 50 ms}
output: {history: false}
needles:
)";

std::string needle(const std::string& height, bool settles = true) {
  return "  - height: " + height + R"(
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion:
      - insert: {speed: 2 cm/s, depth: 4 cm}
      - implant
      - retract: {speed: 2 cm/s}
)" + std::string(settles ? "      - settle: {duration: 50 ms}\n" : "");
}

// Fifteen of them wore the mesh out where it stayed as each had left it.
TEST(ManyNeedles, OnOnePathBecomeAlike) {
  constexpr int n = 40;
  std::string text = tissue;
  for (int i = 0; i < n; ++i) text += needle("3.2 cm");
  Simulation simulation(MPI_COMM_WORLD, scene_of(text), true);
  run_to_end(simulation);
  const auto errors = simulation.placement_errors();
  ASSERT_EQ(errors.size(), std::size_t(n));
  // The first one cuts, the others go where it has cut, and on a little, each less than the one before.
  EXPECT_GT(errors[0], errors[1]);
  EXPECT_NEAR(errors[n - 1], errors[n - 3], 1e-6);
  EXPECT_NEAR(errors[n - 1], errors[n - 2], 2e-6);
  EXPECT_LT(simulation.energies().strain, 1e-12);
}

// The second one finds the mesh as the first did, and no cut where it goes.
TEST(ManyNeedles, OnPathsOfTheirOwnAreWhatEachIsAlone) {
  const std::string other = "4.4 cm";
  const double alone = placement_error(scene_of(tissue + needle(other)));
  Simulation simulation(MPI_COMM_WORLD, scene_of(tissue + needle("2.9 cm") + needle(other)), false);
  run_to_end(simulation);
  EXPECT_NEAR(simulation.placement_errors().at(1), alone, 1e-9);
}

// Tissue that still moves keeps its energy but for what interpolation takes.
TEST(ManyNeedles, TissueInMotionIsTakenOver) {
  const Scene scene = scene_of(tissue + needle("3.2 cm", false) + needle("3.2 cm"),
                               {"time.method=implicit", "time.step=10 ms"});
  Simulation simulation(MPI_COMM_WORLD, scene, true);
  run_to_end(simulation);
  EXPECT_EQ(simulation.seeds().size(), 2U);
  const Energies& energies = simulation.energies();
  EXPECT_LT(std::abs(energies.edits), 0.05 * energies.external) << energies.edits;
}

// A body force of next to nothing makes loads anew with every edit, which changes nothing.
TEST(ManyNeedles, TractionsFollowTheSkin) {
  const auto error = [](const std::string& body) {
    const std::string loads =
        "loads: {traction: [{curve: right, force: [8 N/m, 0 N/m]}]" + body + "}\n";
    Simulation simulation(MPI_COMM_WORLD,
                          scene_of(loads + tissue + needle("2.83 cm") + needle("3.37 cm")), false);
    run_to_end(simulation);
    return simulation.placement_errors().at(1);
  };
  EXPECT_NEAR(error(""), error(", body: [{force: [1e-9 N/m^3, 0 N/m^3]}]"), 1e-9);
}

}  // namespace
}  // namespace stylet
