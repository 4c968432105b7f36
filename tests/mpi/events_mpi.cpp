// A part that a scene does not declare costs nothing: its log events never begin.
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/loader.hpp"
#include "stylet/simulation/recorder.hpp"
#include "stylet/simulation/simulation.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace stylet {

namespace {

const std::string plain = R"(mesh: {rectangle: {size: [8 cm, 6 cm], columns: 12, rows: 9}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}}
supports: {left: fixed}
loads: {traction: [{curve: right, force: [6 N/m, 1 N/m], start: 0.01 s}]}
time: {step: 10 ms, duration: 0.5 s}
output: {history: false}
)";

const std::vector<std::string> names = {"StyletEdit",    "StyletGather",  "StyletSnapshot",
                                        "StyletEnergy",  "StyletRecord",  "StyletFactor",
                                        "StyletSolve",   "StyletForward", "StyletAssemble",
                                        "StyletPattern", "StyletOrder"};

using Counts = std::map<std::string, int>;

Counts counts() {
  Counts counts;
  for (const auto& name : names) counts[name] = event_count(name);
  return counts;
}

/// How often each event began while the scene ran, from its construction to its last step.
Counts events_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  check(PetscLogDefaultBegin());
  const Counts before = counts();
  const Scene scene = load_scene("scene.yaml", text, overrides);
  const auto folder = std::filesystem::temp_directory_path() /
                      ("stylet_events_" + std::to_string(size_of(MPI_COMM_WORLD)));
  std::filesystem::create_directories(folder);
  Simulation simulation(MPI_COMM_WORLD, scene, scene.output.history);
  Recorder recorder(MPI_COMM_WORLD, simulation, folder.string());
  while (!simulation.done()) {
    const auto step = simulation.step();
    if (step.sub_steps > 0) recorder.record(simulation, step);
  }
  recorder.finish(simulation);
  Counts after = counts();
  for (auto& [name, n] : after) n -= before.at(name);
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) std::filesystem::remove_all(folder);
  return after;
}

void expect_no_extras(const Counts& n) {
  for (const char* part : {"StyletEdit", "StyletGather", "StyletSnapshot"}) {
    EXPECT_EQ(n.at(part), 0) << part;
  }
  // The tissue is assembled once, where its pattern is made.
  EXPECT_EQ(n.at("StyletPattern"), 1);
  EXPECT_EQ(n.at("StyletAssemble"), 1);
}

TEST(Events, UnknownNameCountsZero) {
  EXPECT_EQ(event_count("StyletNoSuchEvent"), 0);
}

TEST(Events, StaticSceneFactorsAndSolvesOnce) {
  const auto n = events_of(plain, {"time.method=quasi_static", "time.duration=10 ms"});
  expect_no_extras(n);
  EXPECT_EQ(n.at("StyletFactor"), 1);
  EXPECT_EQ(n.at("StyletSolve"), 1);
}

TEST(Events, FiftyEqualStepsFactorOnce) {
  const auto n = events_of(plain);
  expect_no_extras(n);
  EXPECT_EQ(n.at("StyletFactor"), 1);
  EXPECT_EQ(n.at("StyletForward"), 50);
  EXPECT_EQ(n.at("StyletSolve"), 50);
}

TEST(Events, LoadAtTheStartNeedsNoFactorOfTheMass) {
  // M a = f gives the acceleration at t = 0, by conjugate gradients.
  const auto n = events_of(plain, {"loads.traction.0.start=0 s"});
  expect_no_extras(n);
  EXPECT_EQ(n.at("StyletFactor"), 1);
  EXPECT_EQ(n.at("StyletSolve"), 50);
}

TEST(Events, AnotherStepFactorsAnewInTheSameOrder) {
  // The load begins at once: two half steps of another scheme, then whole steps again.
  const auto n =
      events_of(plain, {"time.scheme=generalised_alpha", "loads.traction.0.start=45 ms"});
  expect_no_extras(n);
  EXPECT_EQ(n.at("StyletFactor"), 3);
  EXPECT_EQ(n.at("StyletOrder"), 1);
}

TEST(Events, ExplicitSceneNeverSolves) {
  const auto n = events_of(plain, {"time.method=explicit", "time.duration=20 ms"});
  expect_no_extras(n);
  EXPECT_EQ(n.at("StyletFactor"), 0);
  EXPECT_EQ(n.at("StyletForward"), 0);
  EXPECT_EQ(n.at("StyletSolve"), 0);
}

TEST(Events, DampingAddsNoSolves) {
  const auto n = events_of(plain, {"tissue.damping.stiffness_factor=0.05 s"});
  expect_no_extras(n);
  EXPECT_EQ(n.at("StyletFactor"), 1);
  EXPECT_EQ(n.at("StyletSolve"), 50);
}

TEST(Events, DeclaredPartsShowUp) {
  // The test would be empty if the names were wrong: with everything declared all are counted.
  const auto n = events_of(
      plain + R"(needles:
  - height: 31 mm
    cutting: {cutting_force: 1.7 N}
    motion: [insert: {speed: 2 cm/s, depth: 1 cm}]
)",
      {"loads.traction=[]", "time={step: 50 ms}", "output={history: true, snapshots: 0.1 s}"});
  for (const auto& name : names) EXPECT_GT(n.at(name), 0) << name;
}

TEST(Events, EnergyIsWeighedOnceAStepAndRarelyIfExplicit) {
  for (const std::string history : {"true", "false"}) {
    const auto n = events_of(plain, {"output.history=" + history});
    EXPECT_EQ(n.at("StyletEnergy"), 50);
    EXPECT_EQ(n.at("StyletSnapshot"), 0);
    EXPECT_EQ(n.at("StyletEdit"), 0);
  }
  // Below 1 ms, the step of the clock.
  const auto n = events_of(plain, {"time.method=explicit", "time.duration=20 ms"});
  EXPECT_LT(n.at("StyletEnergy"), 20);
}

}  // namespace

}  // namespace stylet
