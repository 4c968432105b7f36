// Runs that must end with an error that names the cause, and never with a number.
#include "stylet/base/errors.hpp"

#include "support/body.hpp"
#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stylet {
namespace {

using testing::HasSubstr;

const std::string pulled = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 16, rows: 12}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}}
supports: {left: fixed}
loads: {traction: [{curve: right, force: [6 N/m, 0 N/m]}]}
time: {method: explicit, step: 5 ms, duration: 0.5 s}
)";

const std::string pierced = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 16, rows: 12}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 3.1 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    motion: [insert: {speed: 2 cm/s, depth: 4 cm}]
time: {step: 20 ms}
)";

template <class Error>
std::string message_of(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  try {
    Simulation simulation(MPI_COMM_WORLD, scene_of(yaml, overrides), false);
    run_to_end(simulation);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Refusal, UnstableExplicitStepsAreEndedByTheirEnergyLongBeforeTheyOverflow) {
  {
    Simulation stable(MPI_COMM_WORLD, scene_of(pulled), false);
    run_to_end(stable);
    EXPECT_LT(stable.body().ledger().worst_excess(), 1e-2);
  }
  // Above 1, which no scene file may ask for. The element bound is up to 1.7 times too strict.
  for (const double safety : {1.8, 4.0}) {
    Scene scene = scene_of(pulled);
    scene.time.safety = safety;
    Simulation simulation(MPI_COMM_WORLD, scene, false);
    std::string message;
    try {
      run_to_end(simulation);
    } catch (const NumericalError& error) {
      message = error.what();
    }
    EXPECT_THAT(message, HasSubstr("energy grew without work: kinetic")) << safety;
    EXPECT_THAT(message, testing::StartsWith("at t = 0."));
    // The worst case, 14 times too long, grows by 1e3 a step, and a check comes every 20 steps.
    EXPECT_LT(simulation.energies().strain, 1e100);
  }
}

TEST(Refusal, StepsThatDoNotResolveTheInsertion) {
  // 2 s of insertion.
  EXPECT_THAT(message_of<InputError>(pierced, {"time.step=0.51 s"}),
              HasSubstr("test.yaml: key 'time.step': steps of 0.51 s are too long for needle "
                        "'needle1', which is inserted in 2 s; allowed: at most a quarter of that, "
                        "0.5 s"));
  EXPECT_EQ(message_of<InputError>(pierced, {"time.step=0.5 s"}), "no error");
  // Explicit steps are cut to the stable one.
  EXPECT_EQ(message_of<InputError>(pierced, {"time.step=3 s", "time.method=explicit",
                                             "tissue.damping={mass_factor: 100 1/s}"}),
            "no error");
}

TEST(Refusal, ExplicitStepsOfNearlyIncompressibleTissueNameTheEditsOfTheMesh) {
  EXPECT_THAT(message_of<NumericalError>(
                  pierced, {"time.method=explicit", "tissue.damping={mass_factor: 100 1/s}",
                            "tissue.plane=strain", "tissue.regions.tissue.poisson_ratio=0.49999",
                            "needles.0.motion.0.insert.speed=50 cm/s"}),
              HasSubstr("edits of the mesh added"));
}

TEST(Refusal, LinearSolverThatDoesNotConverge) {
  check(PetscOptionsSetValue(nullptr, "-ksp_max_it", "1"));
  const std::string message = message_of<NumericalError>(pierced);
  check(PetscOptionsClearValue(nullptr, "-ksp_max_it"));
  EXPECT_THAT(message, testing::StartsWith("at t = "));
  EXPECT_THAT(message, HasSubstr("the linear solver did not converge for"));
  EXPECT_THAT(message, HasSubstr("DIVERGED_ITS after 1 iterations"));
}

TEST(Refusal, NeedleThatWouldLeaveTheFarSide) {
  EXPECT_THAT(message_of<InputError>(pierced, {"needles.0.motion.0.insert.depth=8 cm"}),
              HasSubstr("key 'needles.0.motion.0.insert': ends 0.08 m behind the entry point"));
}

// Without inertia a rigid motion has no resistance.
TEST(Refusal, QuasiStaticTissueHasToBeHeld) {
  const auto with = [](const std::string& supports) {
    return message_of<InputError>(pulled, {"time={method: quasi_static}", "supports=" + supports});
  };
  EXPECT_THAT(with("{}"), HasSubstr("moving along x"));
  EXPECT_THAT(with("{left: roller}"), HasSubstr("moving along y"));
  EXPECT_THAT(with("{left: roller, bottom: roller}"), "no error");
  EXPECT_THAT(with("{left: fixed}"), "no error");
}

}  // namespace
}  // namespace stylet
