// What must hold whatever the parameters: forces balance, units cancel, mirror images agree.
#include "support/body.hpp"
#include "support/scenes.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

TEST(Balance, SupportsCarryTheForceOfAQuasiStaticNeedle) {
  Simulation simulation(MPI_COMM_WORLD,
                        reference_scene({"time.method=quasi_static", "time.step=20 ms"}), false);
  const auto supports = dofs_of(simulation.mesh(), {"left", "top", "bottom"});
  double peak = 0;
  double worst = 0;
  run_to_end(simulation, [&](const StepRecord& record) {
    const auto force =
        product(simulation.tissue(), simulation.tissue().stiffness(), simulation.state().u.get());
    double along = 0;
    for (const int dof : supports) {
      if (dof % 2 == Axis::along_component) along += force[static_cast<std::size_t>(dof)];
    }
    // The needle pushes the tissue by `total` in its direction, the supports push back.
    const double needle = record.needle.forces.total();
    peak = std::max(peak, std::abs(needle));
    worst = std::max(worst, std::abs(along - needle));
  });
  RecordProperty("peak_N", std::to_string(peak));
  RecordProperty("imbalance_nN", std::to_string(1e9 * worst));
  EXPECT_GT(peak, 4);
  EXPECT_LT(worst, 1e-9 * peak);  // the solver's relative tolerance is 1e-11
}

// Tissue at rest gets a velocity in the very step at whose end the load begins.
TEST(Balance, OnsetOfALoadIsWorkInExplicitSteps) {
  const auto scene = scene_of(R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 12, rows: 9}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}}
supports: {left: fixed}
loads: {traction: [{curve: right, force: [6 N/m, 1 N/m], start: 10 ms}]}
time: {method: explicit, step: 0.25 ms, duration: 20 ms}
)");
  Simulation simulation(MPI_COMM_WORLD, scene, true);
  bool moving = false;
  run_to_end(simulation, [&](const StepRecord&) {
    const Energies& e = simulation.energies();
    if (moving || e.kinetic == 0) return;
    moving = true;
    EXPECT_NEAR(e.external, e.kinetic, 1e-10 * e.kinetic);  // round-off
  });
  EXPECT_TRUE(moving);
}

std::vector<std::string> scaled(double factor) {
  const auto times = [&](const std::string& key, double value, const std::string& unit) {
    return key + "=" + std::to_string(factor * value) + " " + unit;
  };
  std::vector<std::string> all;
  for (const std::string region : {"prostate", "surrounding"}) {
    all.push_back(times("tissue.regions." + region + ".youngs_modulus", 60, "kPa"));
    all.push_back(times("tissue.regions." + region + ".density", 1000, "kg/m^3"));
  }
  all.push_back(times("membrane.puncture_force", 2.55, "N"));
  all.push_back(times("needles.0.cutting.cutting_force", 1.7, "N"));
  all.push_back(times("needles.0.friction.static_force", 195, "N/m"));
  all.push_back(times("needles.0.friction.kinetic_force", 130, "N/m"));
  return all;
}

TEST(Balance, ForcesScaledWithStiffnessAndDensityLeaveThePlacement) {
  const double error = placement_error(reference_scene());
  for (const double factor : {0.1, 3.0}) {
    // Round-off decides differently at most where a threshold is met within 1e-9.
    EXPECT_NEAR(placement_error(reference_scene(scaled(factor))), error, 1e-9)
        << "factor " << factor;
  }
}

TEST(Balance, ThicknessScalesForcesOnly) {
  const double error = placement_error(reference_scene());
  auto overrides = scaled(2);
  for (auto& o : overrides) {
    if (o.find("regions") != std::string::npos) o = "tissue.thickness=2 cm";
  }
  EXPECT_NEAR(placement_error(reference_scene(overrides)), error, 1e-9);
}

// A mesh that is its own mirror image in y = 3 cm.
const std::string symmetric = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 32, rows: 24}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 3 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion: [insert: {speed: 2 cm/s, position: 3.5 cm}, implant, retract: {speed: 2 cm/s}, settle]
targets: {seed: [3.5 cm, 3 cm]}
probes: {above: [3 cm, 4.5 cm], below: [3 cm, 1.5 cm]}
time: {step: 10 ms, until: implanted}
)";

// Far below what tissue moves and far above round-off and the solver's tolerance.
constexpr double same = 1e-9;  // m

TEST(Mirror, NeedleOnTheAxisOfSymmetryKeepsTheTissueSymmetric) {
  Simulation simulation(MPI_COMM_WORLD, scene_of(symmetric), false);
  double along = 0;
  double difference = 0;
  run_to_end(simulation, [&](const StepRecord&) {
    const auto at = simulation.body().world(simulation.probes());
    along = std::max(along, std::abs(at[0].x - 0.03));
    difference =
        std::max({difference, std::abs(at[0].x - at[1].x), std::abs(at[0].y + at[1].y - 0.06),
                  std::abs(simulation.needle()->tip_point(simulation.mesh()).y - 0.03)});
  });
  RecordProperty("difference_nm", std::to_string(1e9 * difference));
  EXPECT_GT(along, 1e-3);
  EXPECT_LT(difference, same);
}

TEST(Mirror, NeedleAboveAndBelowTheAxisMissAlike) {
  for (const double off : {0.0013, 0.0071}) {  // between grid lines 2.5 mm apart
    const auto error = [&](double height) {
      const std::string y = std::to_string(height);
      return placement_error(scene_of(
          symmetric, {"needles.0.height=" + y + " m", "targets.seed=[0.035 m, " + y + " m]"}));
    };
    const double above = error(0.03 + off);
    RecordProperty("above_mm", std::to_string(1e3 * above));
    const double below = error(0.03 - off);
    RecordProperty("difference_nm", std::to_string(1e9 * (below - above)));
    EXPECT_NEAR(below, above, same) << "off the axis by " << off << " m";
  }
}

}  // namespace
}  // namespace stylet
