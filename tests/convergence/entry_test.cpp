// A needle that breaks in: how deep it is, what it bears and how far it dents a membrane at the skin
// have a limit on finer meshes at every depth, for every law and step. tests/README.md has the tables.
#include "support/body.hpp"
#include "support/scenes.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

const std::string block = R"(
mesh: {rectangle: {size: [7 cm, 5 cm], columns: 21, rows: 15}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 30 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 2.2 cm
    cutting: {cutting_force: 1.1 N, tip_length: 6 mm}
    motion: [insert: {speed: 2 cm/s, depth: 16 mm}]
time: {method: quasi_static, step: 10 ms}
)";

struct Tip {
  double gap = 0;  ///< of the needle's tip in the world ahead of the tissue that it stands in (mm)
  double least = 0;  ///< smallest tip force once the tip was in by half of its length (N)
};

Tip at_depth(double depth, int refine, std::vector<std::string> overrides = {}) {
  overrides.push_back("needles.0.motion.0.insert.depth=" + std::to_string(depth) + " mm");
  overrides.push_back("mesh.refine=" + std::to_string(refine));
  Simulation simulation(MPI_COMM_WORLD, scene_of(block, overrides), false);
  Tip tip{0, 1e300};
  run_to_end(simulation, [&](const StepRecord& step) {
    const double in = 0.07 - simulation.needle()->tip_point().x;
    if (in > 0.003) tip.least = std::min(tip.least, step.needle.forces.tip);
  });
  const Needle& needle = *simulation.needle();
  const ReferencePoint at = needle.tip_point().in_plane();
  tip.gap = 1e3 * (needle.tip() - Axis::along(at));
  return tip;
}

TEST(Entry, HasALimitAtEveryDepth) {
  for (const double depth : {3.0, 5.0, 8.0, 12.0, 16.0, 24.0}) {
    const double coarse = at_depth(depth, 1).gap;
    const double middle = at_depth(depth, 2).gap;
    const double fine = at_depth(depth, 3).gap;
    // Order 1 for a load that ends in the tissue; where it stands among the nodes leaves noise of a few
    // hundredths of the answer.
    EXPECT_LT(std::abs(fine - middle), 0.7 * std::abs(middle - coarse) + 0.02) << depth;
    EXPECT_LT(std::abs(fine - middle), 0.05 * fine) << depth;
  }
}

TEST(Entry, DoesNotDependOnTheStep) {
  for (const double depth : {4.0, 10.0, 20.0}) {
    const double fine = at_depth(depth, 1, {"time.step=2 ms"}).gap;
    // Seven hand-overs in the longest step; a consistent cut leaves 1e-4 of its travel.
    for (const std::string step : {"10 ms", "40 ms"}) {
      EXPECT_NEAR(at_depth(depth, 1, {"time.step=" + step}).gap, fine, 2e-3) << depth << step;
      EXPECT_NEAR(at_depth(depth, 3, {"time.step=" + step}).gap,
                  at_depth(depth, 3, {"time.step=4 ms"}).gap, 2e-3)
          << depth << step;
    }
  }
}

TEST(Entry, IsTheSameForLaggedCutting) {
  for (const double depth : {5.0, 10.0, 20.0}) {
    const double consistent = at_depth(depth, 1).gap;
    const auto lagged = [&](const std::string& step) {
      return at_depth(depth, 1, {"needles.0.cutting.law=lagged", "time.step=" + step}).gap;
    };
    // It is late by what the needle moves in a step: 20 um.
    EXPECT_NEAR(lagged("1 ms"), consistent, 0.03) << depth;
    EXPECT_LT(std::abs(lagged("1 ms") - consistent), std::abs(lagged("8 ms") - consistent));
  }
}

TEST(Entry, TheTipIsNeverWithoutAForce) {
  for (int refine = 0; refine < 3; ++refine) EXPECT_GT(at_depth(24, refine).least, 0.4);
}

/// Newtons per metre of needle while a membrane at the skin holds it.
double dent(int columns) {
  Simulation simulation(
      MPI_COMM_WORLD,
      scene_of(block,
               {"membrane={polygon: [[1 cm, 1 cm], [7 cm, 1 cm], [7 cm, 4 cm], [1 cm, 4 cm]], "
                "puncture_force: 1.5 N}",
                "mesh.rectangle.columns=" + std::to_string(columns),
                "mesh.rectangle.rows=" + std::to_string(5 * columns / 7)}),
      false);
  double stiffness = 0;
  run_to_end(simulation, [&](const StepRecord& step) {
    const Needle& needle = *simulation.needle();
    if (!needle.at_membrane()) return;
    stiffness = step.needle.forces.tip / (needle.tip() - needle.skin());
  });
  EXPECT_EQ(simulation.counts().needle.punctures, 1);
  return stiffness;
}

TEST(Entry, TheDentOfAMembraneAtTheSkinHasALimit) {
  const double coarse = dent(21);
  const double middle = dent(42);
  const double fine = dent(84);
  const double finest = dent(168);
  // A point force would soften by 2 ln 2 / (pi E t), the same amount of compliance, at every halving.
  EXPECT_LT(1 / fine - 1 / middle, 0.7 * (1 / middle - 1 / coarse));
  EXPECT_LT(1 / finest - 1 / fine, 0.7 * (1 / fine - 1 / middle));
  EXPECT_NEAR(finest, fine, 0.02 * fine);
}

}  // namespace
}  // namespace stylet
