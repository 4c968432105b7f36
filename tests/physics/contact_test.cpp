// Contact problems that are hard to solve and have a solution.
#include "support/scenes.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

const std::string pierced = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 16, rows: 12}}
tissue:
  plane: stress
  formulation: p1
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 3.1 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion:
      - insert: {speed: 2 cm/s, depth: 4 cm}
      - retract: {speed: 2 cm/s}
time: {step: 20 ms}
)";

int solves_of(const std::vector<std::string>& overrides) {
  Simulation simulation(MPI_COMM_WORLD, scene_of(pierced, overrides), false);
  run_to_end(simulation);
  return simulation.counts().passes;
}

TEST(Contact, ManyNodesThatPushEachOtherSettle) {
  // Nearly incompressible: a node that starts to slide changes the force on all others. Changing the
  // first wrong contact alone counts in binary, 500 solves were not enough for one step.
  EXPECT_LT(solves_of({"tissue.plane=strain", "tissue.regions.tissue.poisson_ratio=0.49999"}),
            2000);
}

TEST(Contact, TipInTissueThatIsSqueezedFlatGoesOn) {
  // All of the shaft sticks, and the tip squeezes what is ahead: it gains 1 % of its advance.
  EXPECT_LT(solves_of({"needles.0.friction.static_force=1e6 N/m",
                       "needles.0.friction.kinetic_force=1e6 N/m"}),
            2000);
}

}  // namespace
}  // namespace stylet
