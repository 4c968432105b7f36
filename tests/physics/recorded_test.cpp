// A procedure that was recorded runs again with the same bits.
#include "stylet/simulation/recorded.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/simulation/recorder.hpp"
#include "stylet/simulation/recording.hpp"

#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

namespace stylet {
namespace {

const std::string tissue = two_regions + "targets: {seed: [4 cm, 3.2 cm], other: [3 cm, 3.2 cm]}\n";

/// A scene for a hand: without needles, which then need no duration.
Scene live_scene(const std::string& time) {
  return for_live_hand(scene_of(tissue + time, {"time.duration=1 s"}));
}

const std::string implicit = "time: {step: 10 ms}";
const std::string averaged = "time: {step: 10 ms, scheme: average_acceleration}";
const std::string quasi_static = "time: {step: 10 ms, method: quasi_static}";
const std::string central = "time: {step: 10 ms, method: explicit}";

NeedleParameters needle_for(const Scene& scene) {
  NeedleParameters needle;
  needle.height = 0.032;
  needle.cutting.cutting_force = 1.7;
  needle.cutting.tip_length = 6e-3;
  const bool is_explicit = scene.time.method == TimeMethod::explicit_newmark;
  needle.cutting.law = is_explicit ? CuttingLaw::lagged : CuttingLaw::consistent;
  needle.friction = FrictionParameters{195, 130, 1e-3, 1.5e-3};
  return needle;
}

struct Outcome {
  std::vector<double> errors;
  std::vector<double> u;
  double peak = 0;
  double time = 0;
};

Outcome outcome_of(const Simulation& simulation) {
  return {simulation.placement_errors(), gather_all(simulation.state().u.get()),
          simulation.counts().peak_needle_force, simulation.time()};
}

void expect_same_bits(const Outcome& a, const Outcome& b) {
  ASSERT_FALSE(a.errors.empty());
  EXPECT_EQ(a.errors, b.errors);
  EXPECT_EQ(a.peak, b.peak);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.u, b.u);
}

class RecordedProcedure : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "recorded_" + std::to_string(::getpid());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  [[nodiscard]] static std::string text_of_file(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
  [[nodiscard]] Scene recorded() const {
    return load_scene(path("scene.yaml"), text_of_file(path("scene.yaml")));
  }
  /// With `looks`, as a window does, at the state after each step.
  Outcome live(const std::string& time, bool looks) {
    const Scene scene = live_scene(time);
    ProcedureLog log(scene, folder_);
    auto owned = std::make_unique<RecordingHand>(log);
    RecordingHand& hand = *owned;
    Simulation simulation(MPI_COMM_WORLD, scene, false, std::move(owned));
    const auto pass = [&](int steps) {
      for (int i = 0; i < steps; ++i) {
        simulation.step();
        if (looks && i % 3 == 0) (void)simulation.state();
      }
    };
    pass(3);
    hand.enter(needle_for(scene));
    hand.move(0.02);
    pass(60);
    hand.change("tissue.regions.gland.youngs_modulus", 80e3);
    hand.change("needle.cutting.cutting_force", 1.5);
    hand.change("hand.speed_limit", 0.1);
    if (scene.time.method != TimeMethod::quasi_static)
      hand.change("tissue.damping.mass_factor", 20);
    hand.move(0.0173);
    pass(81);
    hand.move(0.03);
    log.flush();  // as after a second: no new action
    pass(7);
    log.flush();
    pass(23);
    hand.implant("seed");
    hand.move(-0.031);
    pass(180);
    hand.move(0);
    pass(20);
    hand.finish();
    pass(1);
    EXPECT_TRUE(simulation.done());
    EXPECT_TRUE(simulation.needle()->released());
    return outcome_of(simulation);
  }
  static Outcome replayed(const Scene& scene) {
    Simulation simulation(MPI_COMM_WORLD, scene, true);
    run_to_end(simulation);
    return outcome_of(simulation);
  }

 private:
  std::string folder_;
};

TEST_P(RecordedProcedure, HasTheSameBits) {
  const Outcome happened = live(GetParam(), true);
  EXPECT_GT(happened.errors.front(), 1e-3);
  expect_same_bits(happened, replayed(recorded()));
  expect_same_bits(happened, live(GetParam(), false));
}

INSTANTIATE_TEST_SUITE_P(Methods,
                         RecordedProcedure,
                         testing::Values(implicit, averaged, quasi_static, central));

using Recording = RecordedProcedure;

TEST_F(Recording, RunsInOtherSteps) {
  const Outcome happened = live(implicit, false);
  Scene scene = recorded();
  for (const double step : {5e-3, 4e-3, 20e-3}) {
    scene.time.step = step;
    const Outcome again = replayed(scene);
    EXPECT_NEAR(again.time, happened.time, 1e-9);
    EXPECT_NEAR(again.errors.at(0), happened.errors.at(0), 0.1e-3);
  }
}

TEST_F(Recording, CutAtAnyByteHasTheRowsBefore) {
  (void)live(quasi_static, false);
  const std::string whole = text_of_file(path("procedure.yaml"));
  std::string note;
  const auto all = read_procedure("p", whole, note);
  EXPECT_EQ(note, "");
  ASSERT_GT(all.size(), 8U);
  std::size_t before = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto rows = read_procedure("p", whole.substr(0, size), note);
    ASSERT_LE(rows.size(), all.size());
    ASSERT_GE(rows.size(), before);
    before = rows.size();
    const bool is_torn = size > 0 && whole[size - 1] != '\n';
    EXPECT_EQ(note.empty(), !is_torn);
    for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_EQ(to_line(rows[i]), to_line(all[i]));
  }
}

TEST_F(Recording, OfAKilledProgramRunsAsFarAsItGot) {
  (void)live(quasi_static, false);
  const std::string whole = text_of_file(path("procedure.yaml"));
  const std::size_t cut = whole.find("implant") + 4;
  std::ofstream(path("procedure.yaml"), std::ios::trunc) << whole.substr(0, cut);
  Simulation simulation(MPI_COMM_WORLD, recorded(), false);
  EXPECT_THAT(simulation.procedure_note(), testing::HasSubstr("last row"));
  run_to_end(simulation);
  EXPECT_NEAR(simulation.time(), 1.74, 1e-9);
  EXPECT_TRUE(simulation.seeds().empty());
}

TEST_F(Recording, LeavesOutWhatWasUndone) {
  const std::string text =
      "- {move: {speed: 0 m/s, duration: 1 s, steps: 10}}\n"
      "- {implant: {target: a}}\n"
      "- {undo: {rows: 1}}\n"
      "- {implant: {target: b}}\n"
      "- {implant: {target: c}}\n"
      "- {undo: {rows: 2}}\n";
  std::string note;
  const auto rows = read_procedure("p", text, note);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1].target, "b");
}

TEST_F(Recording, UndoneStepsAreNotReplayed) {
  const Scene scene = live_scene(quasi_static);
  const auto make = [&](ProcedureLog& log, bool with_detour) {
    auto owned = std::make_unique<RecordingHand>(log);
    RecordingHand& hand = *owned;
    auto simulation = std::make_unique<Simulation>(MPI_COMM_WORLD, scene, false, std::move(owned));
    hand.enter(needle_for(scene));
    hand.move(0.02);
    for (int i = 0; i < 100; ++i) simulation->step();
    const std::size_t mark = hand.mark();
    if (with_detour) {
      hand.move(-0.01);
      for (int i = 0; i < 5; ++i) simulation->step();
      hand.undo(mark);
      return simulation;
    }
    hand.implant("seed");
    simulation->step();
    return simulation;
  };
  {
    ProcedureLog log(scene, path(""));
    (void)make(log, true);
  }
  const std::string detour = text_of_file(path("procedure.yaml"));
  ProcedureLog log(scene, path(""));
  (void)make(log, false);
  log.flush();
  std::string note;
  const auto kept = read_procedure("p", detour, note);
  const auto rows = read_procedure("p", text_of_file(path("procedure.yaml")), note);
  ASSERT_EQ(kept.size(), 2U);
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(to_line(kept[i]), to_line(rows[i]));
}

TEST_F(Recording, ThatIsWrongIsRefusedWithItsLine) {
  const auto refusal = [](const std::string& text) -> std::string {
    std::string note;
    try {
      (void)read_procedure("p.yaml", text, note);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const std::string good = "- {implant: {target: a}}\n";
  EXPECT_THAT(refusal(good + "- {move: {speed: 1 m/s, duration: 0 s, steps: 3}}\n"),
              testing::AllOf(testing::HasSubstr("p.yaml:2"), testing::HasSubstr("duration")));
  EXPECT_THAT(refusal(good + "- {jump: {}}\n"), testing::HasSubstr("enter, move, implant"));
  EXPECT_THAT(refusal(good + "- {undo: {rows: 2}}\n"), testing::HasSubstr("1 at most"));
  EXPECT_THAT(refusal("implant: {}\n"), testing::HasSubstr("a list of rows"));
  EXPECT_THAT(refusal(good + "- {enter: {height: 1 cm}}\n"), testing::HasSubstr("cutting"));
}

TEST(HandInUse, RefusesANeedleThatNoSceneMayHaveAndGoesOn) {
  const Scene scene = live_scene(implicit);
  auto owned = std::make_unique<LiveHand>();
  LiveHand& hand = *owned;
  Simulation simulation(MPI_COMM_WORLD, scene, false, std::move(owned));
  const auto refusal = [&](const NeedleParameters& needle) -> std::string {
    hand.enter(needle);
    try {
      simulation.step();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  NeedleParameters bad = needle_for(scene);
  bad.cutting.cutting_force = -1;
  EXPECT_THAT(refusal(bad), testing::HasSubstr("cutting_force"));
  bad = needle_for(scene);
  bad.friction->kinetic_force = 300;
  EXPECT_THAT(refusal(bad), testing::HasSubstr("static_force"));
  bad = needle_for(scene);
  bad.height = 1;
  EXPECT_THAT(refusal(bad), testing::HasSubstr("misses"));
  bad = needle_for(scene);
  bad.height = 0.06;
  EXPECT_NE(refusal(bad), "");
  EXPECT_EQ(simulation.needle(), nullptr);
  EXPECT_EQ(refusal(needle_for(scene)), "");
  EXPECT_NE(simulation.needle(), nullptr);
  hand.limit_speed(0.01);
  hand.move(1);
  EXPECT_EQ(hand.speed(), 0.01);
}

TEST_F(Recording, HistoryOfAHandBeginsBeforeItsNeedle) {
  Scene scene = scene_of(tissue + implicit, {"time.duration=1 s"});
  scene.needles = {needle_for(scene)};
  auto owned = std::make_unique<LiveHand>();
  LiveHand& hand = *owned;
  Simulation simulation(MPI_COMM_WORLD, scene, true, std::move(owned));
  Recorder recorder(MPI_COMM_WORLD, simulation, path(""));
  recorder.record(simulation, simulation.step());
  hand.enter(needle_for(scene));
  recorder.record(simulation, simulation.step());
  recorder.close();
  EXPECT_THAT(text_of_file(path("history.csv")), testing::HasSubstr("0.01,nan,nan"));
}

}  // namespace
}  // namespace stylet
