// Needles in space: what has to hold of every one, and what is refused.
#include "stylet/base/errors.hpp"
#include "stylet/simulation/notes.hpp"

#include "support/needles_in_space.hpp"
#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const char* const quasi_static = "time={method: quasi_static, step: 5 ms}";

TEST(NeedleInSpace, OnceOutItsTissueIsAtRest) {
  for (const std::string time :
       {"{method: quasi_static, step: 5 ms}", "{method: implicit, step: 5 ms}"}) {
    Simulation simulation(
        MPI_COMM_WORLD,
        scene_of(needles_in_space, {"time=" + time, "needles.0.motion.5.settle=null",
                                    "needles.1.motion.1.retract.speed=3 cm/s"}),
        true);
    double deepest = 0;
    run_to_end(simulation, [&](const StepRecord& record) {
      deepest = std::max(deepest, simulation.needle()->path_length());
      if (!simulation.needle()->released()) return;
      EXPECT_EQ(record.needle.forces.total(), 0);
    });
    EXPECT_GT(deepest, 0.02);
    const Energies& e = simulation.energies();
    EXPECT_LT(e.strain, 1e-3 * e.external) << time;
    // Implicit steps damp.
    EXPECT_GE(e.external * (1 + 1e-12), e.dissipated) << time;
    EXPECT_LT(e.external, 1.2 * e.dissipated) << time;
    ASSERT_EQ(simulation.seeds().size(), 1U);
    EXPECT_EQ(simulation.entered().size(), 0U);
  }
}

TEST(NeedleInSpace, MembranesHoldUntilTheyBreakAndAreForgottenThen) {
  Simulation with(MPI_COMM_WORLD, scene_of(needles_in_space, {quasi_static}), false);
  const int triangles = static_cast<int>(with.mesh().n_cells());
  ASSERT_GT(triangles, 0);
  double held = 0;
  while (with.seeds().empty()) {
    const StepRecord record = with.step();
    if (with.needle()->at_membrane()) held = std::max(held, record.needle.forces.tip);
  }
  EXPECT_EQ(with.counts().needle.punctures, 1);
  EXPECT_GT(held, 1.7);
  EXPECT_LE(held, 2 * (1 + 1e-6));
  // Quasi-static tissue remembers nothing but contacts, which all slide.
  Simulation without(MPI_COMM_WORLD,
                     scene_of(needles_in_space, {quasi_static, "membrane.puncture_force=1 mN"}),
                     false);
  while (without.seeds().empty()) without.step();
  EXPECT_LT(distance(with.place_of(with.seeds()[0]).x, without.place_of(without.seeds()[0]).x),
            1e-6);
}

// Again along the same way: what is cut has no tip force, and friction as before.
TEST(NeedleInSpace, AWayThatIsCutIsFree) {
  const Scene scene =
      scene_of(needles_in_space,
               {quasi_static, "needles.1.entry=[6 cm, 2.1 cm, 1.9 cm]", "needles.1.target=null",
                "needles.1.direction=[-1, 0, 0]", "needles.1.motion.0.insert.depth=14 mm"});
  Simulation simulation(MPI_COMM_WORLD, scene, false);
  int again = 0;
  run_to_end(simulation, [&](const StepRecord& record) {
    if (simulation.needle()->parameters().name != "needle2") return;
    ++again;
    EXPECT_EQ(record.needle.forces.tip, 0) << record.t;
  });
  EXPECT_GT(again, 10);
  EXPECT_EQ(simulation.counts().needle.punctures, 1);
}

// The same needle through a body that is turned: along each axis, and from both sides.
TEST(NeedleInSpace, EveryDirectionIsAlike) {
  const std::string body = R"(
tissue:
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
targets: {seed: [2 cm, 2 cm, 2 cm]}
mesh: {box: {size: [4 cm, 4 cm, 4 cm], columns: 6, rows: 6, layers: 6}}
)";
  const auto drag_of = [&](const std::string& held, const std::string& entry,
                           const std::string& direction) {
    Simulation simulation(MPI_COMM_WORLD,
                          scene_of(body + "supports: {" + held + ": fixed}\nneedles: [{entry: " +
                                   entry + ", direction: " + direction + R"(, kernel_radius: 8 mm,
  cutting: {cutting_force: 1 N, tip_length: 6 mm}, motion: [insert: {speed: 1 cm/s, depth: 2 cm}, implant]}]
time: {method: quasi_static, step: 100 ms})"),
                          false);
    run_to_end(simulation);
    return norm(simulation.seeds().at(0).displacement);
  };
  // The diagonals of the bricks run alike seen along (1, 1, 1) only.
  const double first = drag_of("left", "[4 cm, 2 cm, 2 cm]", "[-1, 0, 0]");
  EXPECT_NEAR(drag_of("bottom", "[2 cm, 4 cm, 2 cm]", "[0, -3, 0]"), first, 0.03 * first);
  EXPECT_NEAR(drag_of("back", "[2 cm, 2 cm, 5 cm]", "[0, 0, -1]"), first, 0.03 * first);
  EXPECT_NEAR(drag_of("right", "[0 cm, 2 cm, 2 cm]", "[1, 0, 0]"), first, 0.03 * first);
  EXPECT_NEAR(drag_of("front", "[2 cm, 2 cm, -1 cm]", "[0, 0, 1]"), first, 0.03 * first);
}

std::string refusal_of(const std::vector<std::string>& changes) {
  std::vector<std::string> all{quasi_static};
  all.insert(all.end(), changes.begin(), changes.end());
  try {
    Simulation simulation(MPI_COMM_WORLD, scene_of(needles_in_space, all), false);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(NeedleInSpace, WhatHasNoAnswerIsRefused) {
  struct Refused {
    std::vector<std::string> changes;
    std::vector<std::string> words;
  };
  for (const Refused& refused : std::vector<Refused>{
           {{"needles.0.entry=[5 cm, 2 cm, 2 cm]"},
            {"needles.0.entry", "begins inside the tissue"}},
           {{"needles.0.entry=[7 cm, 2 cm, 2 cm]", "needles.0.direction=[0, 1, 0]"},
            {"needles.0.direction", "misses the tissue"}},
           {{"needles.0.direction=[0, 0, 0]"}, {"needles.0.direction", "not 0"}},
           {{"needles.0.direction=null"}, {"needles.0.target", "one of target and direction"}},
           {{"needles.0.target=[0 cm, 2 cm, 2 cm]"},
            {"needles.0.direction", "one of target and direction"}},
           {{"needles.0.entry=null"}, {"needles.0.entry", "required in space"}},
           {{"needles.0.entry=[6 cm, 2 cm]"}, {"needles.0.entry", "[x, y, z]"}},
           {{"needles.0.height=2 cm"}, {"needles.0.height", "only with tissue.plane"}},
           {{"needles.0.kernel_radius=null"}, {"needles.0.kernel_radius", "required in space"}},
           {{"needles.0.kernel_radius=0.7 mm"}, {"needles.0.kernel_radius", "1.3 times"}},
           {{"needles.0.direction=[-1, 0, 4]"}, {"needles.0.direction", "75.9638 degrees"}},
           {{"needles.0.entry=[6 cm, 4 cm, 2 cm]"}, {"an entry farther than kernel_radius"}},
           {{"needles.0.kernel_radius=2 mm"},
            {"needles.0.kernel_radius", "leads through elements"}},
           {{"needles.0.kernel_radius=19.5 mm"},
            {"needles.0.kernel_radius", "of the tissue's surface"}},
           {{"supports.back=fixed", "needles.0.kernel_radius=19.5 mm"},
            {"needles.0.kernel_radius", "held (supports.back)"}},
           {{"supports.right=fixed"}, {"within 0 mm", "held (supports.right)"}},
           {{"needles.0.cutting.tip_length=0 mm"}, {"cutting.tip_length", "> 0 m in space"}},
           {{"needles.0.segment=3 mm"}, {"needles.0.segment", "a third of cutting.tip_length"}},
           {{"needles.0.segment=1 um"}, {"needles.0.segment", "segments of at least"}},
           {{"needles.0.motion.0.insert.depth=70 mm"}, {"needles.0.motion", "leaves the tissue"}},
           {{"needles.0.motion.0.insert={speed: 1 cm/s, position: 3 cm}"}, {"position", "depth"}},
           {{"loads.body=[{force: [0 N/m^3, 0 N/m^3, 1 N/m^3]}]"}, {"loads.body", "straight ways"}},
           {{"prescribed=[{surface: right, displacement: [null, null, 1 mm]}]"},
            {"prescribed", "straight ways"}},
           {{"membrane={surface: right, puncture_force: 1 N}"}, {"membrane.surface", "not closed"}},
           {{"membrane={surface: nowhere, puncture_force: 1 N}"}, {"membrane.surface", "nowhere"}},
           {{"membrane={region: tissue, puncture_force: 1 N}"},
            {"membrane", "behind its entry point"}},
           {{"targets.seed=[4 cm, 2 cm]"}, {"targets.seed", "[x, y, z] in space"}},
           {{"targets.seed=[4 cm, 2 cm, 9 cm]"}, {"targets"}}}) {
    const std::string message = refusal_of(refused.changes);
    for (const std::string& word : refused.words) {
      EXPECT_THAT(message, HasSubstr(word)) << refused.changes.front();
    }
  }
  EXPECT_EQ(refusal_of({}), "none");
}

TEST(NeedleInSpace, TissueDoesNotChangeAroundATrack) {
  Simulation simulation(MPI_COMM_WORLD, scene_of(needles_in_space, {quasi_static}), false);
  simulation.step();
  EXPECT_THROW(simulation.change("tissue.regions.gland.youngs_modulus", 50e3), InputError);
  EXPECT_NO_THROW(simulation.change("needle.cutting.cutting_force", 1.5));
}

TEST(NeedleInSpace, WhatTheNearFieldDoesNotKnowIsSaid) {
  const auto notes_with = [](const std::vector<std::string>& changes) {
    std::vector<std::string> all{quasi_static};
    all.insert(all.end(), changes.begin(), changes.end());
    Simulation simulation(MPI_COMM_WORLD, scene_of(needles_in_space, all), false);
    run_to_end(simulation);
    std::string text;
    for (const std::string& note : notes_of(simulation)) text += note + "\n";
    return text;
  };
  EXPECT_THAT(notes_with({}), testing::Not(HasSubstr("kernel's edge")));
  // A plane of triangles larger than the kernel.
  EXPECT_THAT(notes_with({"needles.0.kernel_radius=4 mm"}), testing::Not(HasSubstr("is no plane")));
  EXPECT_THAT(notes_with({"tissue.regions.gland.youngs_modulus=90 kPa"}),
              HasSubstr("kernel's edge"));
  EXPECT_THAT(notes_with({"supports.back=fixed", "needles.0.kernel_radius=12 mm"}),
              HasSubstr("passes what is held at 19 mm"));
  EXPECT_THAT(notes_with({"membrane.puncture_force=20 N"}), HasSubstr("that it had not broken"));
  EXPECT_THAT(notes_with({"needles.1.target=[4.5 cm, 3.2 cm, 2.2 cm]",
                          "needles.1.motion.0.insert.depth=8 mm",
                          "needles.1.entry=[6.2 cm, 1.2 cm, 2 cm]"}),
              HasSubstr("40 degrees"));
}

}  // namespace
}  // namespace stylet
