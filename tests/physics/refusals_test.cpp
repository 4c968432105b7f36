// Runs that must end with an error that names the cause, and never with a number.
#include "stylet/base/errors.hpp"
#include "stylet/simulation/room.hpp"

#include "support/body.hpp"
#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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
  check(PetscOptionsSetValue(nullptr, "-pc_type", "jacobi"));
  check(PetscOptionsSetValue(nullptr, "-ksp_max_it", "1"));
  const std::string message = message_of<NumericalError>(pierced);
  check(PetscOptionsClearValue(nullptr, "-ksp_max_it"));
  check(PetscOptionsClearValue(nullptr, "-pc_type"));
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

const std::string beside_a_bar = R"(
mesh:
  rectangle:
    size: [8 cm, 6 cm]
    columns: 16
    rows: 12
    curves: [{name: bar, points: [[3 cm, 3 cm], [5 cm, 3 cm]]}]
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed, top: fixed, bottom: fixed, bar: fixed}
needles:
  - height: 3.1 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s,
               slip_speed: 1.5 mm/s}
    motion: [insert: {speed: 2 cm/s, depth: 6 cm}]
time: {step: 40 ms}
)";

// The tissue ahead of a needle is pushed around what is held there.
TEST(Refusal, ANeedleMovesNoHeldPointAndSaysWhichOnesItMeets) {
  int failures = 0;
  for (const char* height : {"3.01 cm", "2.99 cm", "3.1 cm", "3.3 cm"}) {
    for (const char* kind : {"fixed", "roller"}) {
      Simulation simulation(MPI_COMM_WORLD,
                            scene_of(beside_a_bar, {std::string("needles.0.height=") + height,
                                                    std::string("supports.bar=") + kind}),
                            false);
      std::string message;
      try {
        run_to_end(simulation);
      } catch (const NumericalError& error) {
        message = error.what();
        ++failures;
      }
      if (!message.empty()) {
        EXPECT_THAT(message, HasSubstr(std::string(" m of curve 'bar', which is held "
                                                   "(supports.bar: ") +
                                       kind + ")"))
            << height;
      }
      for (const int node : simulation.mesh().nodes_of("bar")) {
        EXPECT_EQ(simulation.mesh().point(node).y, 0.03) << height << " " << kind;
      }
    }
  }
  EXPECT_GT(failures, 0);
}

// What stands in a message is a length and a direction, never a length below zero.
TEST(Refusal, ASeedOutsideTheTissueSaysOnWhichSideOfTheSkinTheTipStands) {
  // A body force draws the tissue away from the needle that has been put in.
  EXPECT_THAT(
      message_of<NumericalError>(
          pierced,
          {"supports={left: fixed}", "loads={body: [{force: [-1e6 N/m^3, 0 N/m^3], start: 1.5 s}]}",
           "targets={seed: [6 cm, 3 cm]}",
           "needles.0.motion=[{insert: {speed: 2 cm/s, depth: 2 cm}}, "
           "{hold: {duration: 3 s}}, {implant: {}}]"}),
      HasSubstr("it stands 20 mm behind the skin's place at entry, and the tissue has moved "
                "away from it"));
  // And one that has been taken out.
  Scene scene = scene_of(pierced);
  const NeedleParameters needle = scene.needles.front();
  scene.needles.clear();
  auto owned = std::make_unique<LiveHand>();
  LiveHand& hand = *owned;
  Simulation simulation(MPI_COMM_WORLD, scene, false, std::move(owned));
  hand.enter(needle);
  hand.move(0.02);
  for (int i = 0; i < 25; ++i) simulation.step();
  hand.move(-0.02);
  for (int i = 0; i < 50; ++i) simulation.step();
  hand.implant();
  try {
    simulation.step();
    ADD_FAILURE() << "a seed in the air";
  } catch (const NumericalError& error) {
    EXPECT_THAT(error.what(), HasSubstr("it stands 10 mm in front of the skin's place at entry"));
  }
}

// A turn leaves 1e-18 m of what is nothing.
TEST(Refusal, NoBoundIsPrintedWithTheRoundOffOfATurn) {
  for (const char* angle :
       {"0 degrees", "30 degrees", "90 degrees", "-90 degrees", "225 degrees"}) {
    const std::string turn = std::string("needle_angle=") + angle;
    for (const std::string& change :
         {std::string("needles.0.height=90 cm"), std::string("probes={far: [1 m, 0 m]}"),
          std::string("membrane={polygon: [[0 m, 0 m], [1 m, 0 m], [0 m, 1 m]], puncture_force: "
                      "1 N}")}) {
      const std::string message = message_of<InputError>(
          pierced, {turn, "supports={left: fixed, right: fixed, top: fixed, bottom: fixed}",
                    "needles.0.height=1 mm", change});
      EXPECT_THAT(message, testing::AnyOf(HasSubstr("spans"), HasSubstr("key '"))) << message;
      EXPECT_THAT(message, testing::Not(testing::ContainsRegex("e-[0-9]"))) << message;
    }
  }
}

/// Behind the place that it begins with.
std::string without_place(const std::string& message) {
  return message.substr(message.find(": key '") + 2);
}

// A scene that was made in code, not read, is refused for the same reason, at the same key.
TEST(Refusal, ASceneMadeInCodeIsCheckedAsOneFromAFileIs) {
  const auto refused = [](Scene scene) {
    scene.document = {};
    scene.file.clear();
    try {
      const Simulation simulation(MPI_COMM_WORLD, std::move(scene), false);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith("scene: key '"));
      return without_place(error.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(refused(scene_of(pierced)), "no error");
  const std::vector<std::pair<std::string, std::function<void(Scene&)>>> faults{
      {"needles.0.cutting.cutting_force=-1 N",
       [](Scene& s) { s.needles[0].cutting.cutting_force = -1; }},
      {"tissue.regions.tissue.poisson_ratio=0.5",
       [](Scene& s) { s.tissue.regions[0].material.poisson_ratio = 0.5; }},
      {"time.step=0 s", [](Scene& s) { s.time.step = 0; }},
      {"tissue.thickness=-1 m", [](Scene& s) { s.tissue.thickness = -1; }},
      {"needles.0.friction={static_force: 1 N/m, kinetic_force: 2 N/m, stick_speed: 1 m/s, "
       "slip_speed: 2 m/s}",
       [](Scene& s) {
         s.needles[0].friction = FrictionParameters{1, 2, 1, 2};
       }},
      {"needles.0.motion.0={hold: {duration: 1 s}}",
       [](Scene& s) {
         s.needles[0].motion[0] = {};
         s.needles[0].motion[0].kind = ActionKind::hold;
         s.needles[0].motion[0].duration = 1;
       }},
      {"prescribed=[{curve: right, displacement: [null, null]}]",
       [](Scene& s) {
         s.prescribed = {{"right", {std::nullopt, std::nullopt}, 0, 0}};
       }},
  };
  for (const auto& [change, fault] : faults) {
    Scene scene = scene_of(pierced);
    fault(scene);
    std::string as_file;
    try {
      (void)scene_of(pierced, {change});
    } catch (const InputError& error) {
      as_file = error.what();
    }
    EXPECT_EQ(refused(scene), without_place(as_file)) << change;
  }
}

// Checked when it was read.
TEST(Refusal, ASceneFromAFileIsNotCheckedASecondTime) {
  Scene scene = scene_of(pierced);
  scene.time.safety = 2;
  EXPECT_NO_THROW(Simulation(MPI_COMM_WORLD, scene, false));
  scene.document = {};
  EXPECT_THROW(Simulation(MPI_COMM_WORLD, scene, false), InputError);
}

// Measured, bytes, on one rank (jobs/README.md).
TEST(Refusal, RoomForTetrahedraIsAsMeasured) {
  Scene scene;
  scene.tissue.plane.reset();
  scene.time.method = TimeMethod::quasi_static;
  struct Measured {
    Formulation formulation;
    double n_cells;
    double bytes;
  };
  for (const auto& [formulation, n_cells, bytes] :
       std::vector<Measured>{{Formulation::p1, 46656, 0.232e9},
                             {Formulation::p1, 157464, 0.833e9},
                             {Formulation::p1_averaged, 46656, 0.563e9},
                             {Formulation::p1_averaged, 157464, 2.08e9},
                             {Formulation::p2, 5832, 0.292e9},
                             {Formulation::p2, 13824, 0.704e9}}) {
    scene.tissue.formulation = formulation;
    EXPECT_NEAR(bytes_needed(scene, n_cells, 1, 16e9) / bytes, 1.07, 0.12) << n_cells;
  }
}

TEST(Refusal, AMeshThatFindsNoRoomIsNotMade) {
  Scene implicit;
  implicit.tissue.plane = Plane::stress;
  Scene explicit_steps = implicit;
  explicit_steps.time.method = TimeMethod::explicit_newmark;
  EXPECT_TRUE(room_for(MPI_COMM_WORLD, implicit, 1000, 0).lack.empty());
  const Room room = room_for(MPI_COMM_WORLD, implicit, 1000, 40);
  EXPECT_THAT(room.lack, testing::AllOf(HasSubstr("1.20893e+27 triangles, which need about"),
                                        HasSubstr(" GB of memory; there are ")));
  // The finest that is named is the finest that fits.
  ASSERT_GE(room.finest, 0);
  EXPECT_TRUE(room_for(MPI_COMM_WORLD, implicit, 1000, room.finest).lack.empty());
  EXPECT_FALSE(room_for(MPI_COMM_WORLD, implicit, 1000, room.finest + 1).lack.empty());
  EXPECT_GE(room_for(MPI_COMM_WORLD, explicit_steps, 1000, 40).finest, room.finest);
  EXPECT_EQ(room_for(MPI_COMM_WORLD, implicit, 1e20, 0).finest, -1);
  EXPECT_THAT(message_of<InputError>(pierced, {"mesh.refine=40"}),
              testing::AllOf(HasSubstr("key 'mesh.refine': 40 makes 4.64"),
                             HasSubstr("allowed here: up to ")));
  EXPECT_THAT(message_of<InputError>(
                  pierced, {"mesh.rectangle.columns=20000000", "mesh.rectangle.rows=20000000"}),
              HasSubstr("key 'mesh': has 8e+14 triangles"));
}

}  // namespace
}  // namespace stylet
