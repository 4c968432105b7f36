// What a hand must not take home: triangles that were turned over, steps that were too long. The window, the
// score, the recording and its replay say the same.
#include "stylet/simulation/notes.hpp"
#include "stylet/view/live_session.hpp"
#include "stylet/view/method_choice.hpp"
#include "stylet/view/publish.hpp"

#include "support/scenes.hpp"
#include "view/reference.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

namespace stylet {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const auto is_beyond = Contains(HasSubstr("beyond small strain"));

/// Quasi-static, of tissue that is this soft, with a recording.
class Procedure {
 public:
  explicit Procedure(const std::string& modulus, const std::vector<std::string>& more = {}) {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = testing::TempDir() + test->name();
    std::filesystem::remove_all(folder_ + "-1");
    std::vector<std::string> all{"time.method=quasi_static", "time.step=10 ms",
                                 "tissue.regions.prostate.youngs_modulus=" + modulus,
                                 "tissue.regions.surrounding.youngs_modulus=" + modulus};
    all.insert(all.end(), more.begin(), more.end());
    LiveOptions options = reference_options(all);
    options.record = folder_;
    run.emplace(MPI_COMM_WORLD, std::move(options));
  }
  ~Procedure() { std::filesystem::remove_all(folder_ + "-1"); }
  Procedure(const Procedure&) = delete;
  Procedure& operator=(const Procedure&) = delete;

  void push_to(double position, double speed = 0.02) {
    run->want(Push{run->height(), speed});
    while (speed * (-position - run->tip()) > 1e-9) run->step();
    run->want(Push{run->height(), 0});
  }
  [[nodiscard]] Frame frame() const {
    Frame frame;
    publish(*run, Colouring::none, frame);
    return frame;
  }
  [[nodiscard]] nlohmann::ordered_json score() const {
    return nlohmann::ordered_json::parse(std::ifstream(folder_ + "-1/score.json"));
  }
  /// By `run`, as it would be another day.
  [[nodiscard]] std::unique_ptr<Simulation> replay() const {
    const std::string file = folder_ + "-1/scene.yaml";
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    auto simulation =
        std::make_unique<Simulation>(MPI_COMM_WORLD, load_scene(file, text.str()), true);
    run_to_end(*simulation);
    return simulation;
  }

  std::optional<LiveRun> run;

 private:
  std::string folder_;
};

TEST(Doubt, TurnedOverTrianglesAreToldOfEverywhere) {
  Procedure hand("15 kPa");
  hand.push_to(0.035);
  EXPECT_GT(hand.frame().inverted, 0);
  hand.run->seed();
  hand.push_to(0.085, -0.04);
  const Frame out = hand.frame();
  // Long after the tissue is well again.
  EXPECT_EQ(out.inverted, 0);
  EXPECT_GT(out.most_inverted, 0);
  ASSERT_EQ(out.seeds.size(), 1U);
  EXPECT_GT(out.seeds[0].turned_over, 0);
  EXPECT_THAT(out.notes, is_beyond);
  const std::string words = last_words(*hand.run);
  EXPECT_THAT(words, AllOf(HasSubstr("mm off, NOT TO BE TRUSTED"), HasSubstr("mm, NOT TO BE")));
  EXPECT_THAT(words, HasSubstr("note: beyond small strain"));

  const auto replay = hand.replay();
  const auto notes = notes_of(*replay);
  EXPECT_EQ(hand.score()["notes"], nlohmann::ordered_json(notes));
  EXPECT_EQ(notes_of(hand.run->simulation()), notes);
  EXPECT_THAT(notes, Contains(AllOf(HasSubstr("turned over"), HasSubstr("'needle1' for 'seed'"))));
  EXPECT_EQ(text_of(score_of(*replay)), text_of(hand.run->finish()));
  EXPECT_EQ(replay->turned_over().triangles, out.most_inverted);
  EXPECT_LT(replay->turned_over().first, replay->turned_over().time);
}

TEST(Doubt, OfSeedsOnlyWhereTheirOwnNeedleTurnedTrianglesOver) {
  Procedure hand("15 kPa");
  hand.push_to(0.072);
  hand.run->seed();
  hand.push_to(0.035);
  hand.run->seed();
  hand.run->step();
  const Frame two = hand.frame();
  ASSERT_EQ(two.seeds.size(), 2U);
  EXPECT_EQ(two.seeds[0].turned_over, 0);
  EXPECT_GT(two.seeds[1].turned_over, 0);
  // What is undone has not been.
  hand.run->undo();
  hand.run->undo();
  EXPECT_EQ(hand.frame().most_inverted, 0);
  EXPECT_THAT(hand.frame().notes, Not(is_beyond));
}

TEST(Doubt, GoodTissueHasNone) {
  Procedure hand("60 kPa");
  hand.push_to(0.035);
  hand.run->seed();
  hand.push_to(0.085, -0.04);
  EXPECT_THAT(hand.frame().notes, IsEmpty());
  EXPECT_THAT(last_words(*hand.run), AllOf(HasSubstr("mm off\n"), Not(HasSubstr("note"))));
  EXPECT_THAT(notes_of(*hand.replay()), IsEmpty());
}

TEST(Doubt, ANeedleThatIsStillInIsSaidAtTheEnd) {
  Procedure hand("60 kPa");
  hand.push_to(0.035);
  hand.run->seed();
  EXPECT_THAT(last_words(*hand.run), HasSubstr("'needle1' is still in"));
  EXPECT_EQ(hand.score()["notes"], nlohmann::ordered_json(notes_of(*hand.replay())));
  // The seed was wanted before the end, and is in the recording.
  EXPECT_EQ(hand.score()["seeds"].size(), 1U);
}

TEST(Doubt, StepsThatAreTooLongForAHand) {
  Procedure hand("60 kPa", {"time.step=0.5 s"});
  EXPECT_GT(hand.frame().way, hand.frame().longest_way);
  hand.push_to(0.045);
  EXPECT_THAT(hand.frame().notes, Contains(AllOf(HasSubstr("went up to 10 mm in a step"),
                                                 HasSubstr("further than 6 mm"))));
  EXPECT_THAT(hand.frame().notes, Not(Contains(HasSubstr("fewer than four steps"))));
  hand.push_to(0.08, -0.04);
  (void)hand.run->finish();
  const auto notes = notes_of(*hand.replay());
  EXPECT_EQ(notes_of(hand.run->simulation()), notes);
  EXPECT_THAT(notes, Contains(HasSubstr("in a step")));
}

TEST(Doubt, FewerThanFourStepsOfAPush) {
  Procedure hand("60 kPa", {"time.step=0.5 s"});
  hand.push_to(0.045, 0.04);
  const auto few = Contains(HasSubstr("fewer than four steps"));
  EXPECT_THAT(hand.frame().notes, Not(few));  // the hand may push on
  hand.run->seed();
  hand.run->step();
  EXPECT_THAT(hand.frame().notes, few);
  (void)hand.run->finish();
  EXPECT_THAT(notes_of(*hand.replay()), few);
}

TEST(Doubt, TimeGoesOnInStepsOfAnyLength) {
  LiveSession session(MPI_COMM_WORLD,
                      reference_options({"time.method=quasi_static", "time.step=0.4 s"}));
  Frame frame;
  for (const double start = clock_seconds(); clock_seconds() - start < 60 && frame.time < 0.9;) {
    (void)session.take(frame);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_GE(frame.time, 0.9);
}

TEST(MethodChoice, TheScenesWhereItKeepsUp) {
  EXPECT_EQ(method_choice("auto", "implicit", 1226).method, "implicit");
  EXPECT_EQ(method_choice("auto", "explicit", 1226).method, "explicit");
  EXPECT_EQ(method_choice("auto", "explicit", 4904).method, "quasi_static");
  EXPECT_THAT(method_choice("auto", "explicit", 4904).reason,
              AllOf(HasSubstr("explicit"), HasSubstr("1226 triangles, here are 4904")));
  EXPECT_EQ(method_choice("auto", "implicit", 78464).method, "quasi_static");
  EXPECT_EQ(method_choice("auto", "quasi_static", 78464).method, "quasi_static");
  EXPECT_EQ(method_choice("", "explicit", 78464).method, "explicit");
  EXPECT_EQ(method_choice("implicit", "explicit", 1226).method, "implicit");
}

LiveOptions with_method(const std::string& method, const std::vector<std::string>& overrides) {
  LiveOptions options = reference_options(overrides);
  options.method = method;
  return options;
}

TEST(MethodChoice, OfAProcedure) {
  const std::vector<std::string> dynamic{"time.method=explicit",
                                         "tissue.damping.stiffness_factor=null",
                                         "tissue.damping.mass_factor=200 1/s"};
  const LiveRun coarse(MPI_COMM_WORLD, with_method("auto", dynamic));
  EXPECT_EQ(coarse.method(), "explicit");
  auto refined = dynamic;
  refined.emplace_back("mesh.refine=1");
  const LiveRun fine(MPI_COMM_WORLD, with_method("auto", refined));
  EXPECT_EQ(fine.method(), "quasi_static");
  EXPECT_THAT(fine.method_reason(), HasSubstr("the quickest"));
  LiveRun asked(MPI_COMM_WORLD, with_method("explicit", {}));
  EXPECT_EQ(asked.method(), "explicit");
  EXPECT_THAT(asked.method_reason(), HasSubstr("asked for"));
  asked.choose_method("implicit");
  EXPECT_EQ(asked.method_reason(), "chosen by hand");
}

}  // namespace
}  // namespace stylet
