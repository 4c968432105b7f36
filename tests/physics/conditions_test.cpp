// Conditions that contradict each other or would vanish, and needles that never come to where a number
// would have a meaning: refused before the run where that shows, else named by it.
#include "stylet/base/errors.hpp"
#include "stylet/scene/quantities.hpp"
#include "stylet/simulation/notes.hpp"
#include "stylet/simulation/recorder.hpp"

#include "pierced.hpp"
#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

template <class Error>
std::string message_of(const std::string& yaml,
                       const std::vector<std::string>& overrides = {},
                       bool run = false) {
  try {
    Simulation simulation(MPI_COMM_WORLD, scene_of(yaml, overrides), false);
    if (run) run_to_end(simulation);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::string refusal(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  return message_of<InputError>(yaml, overrides);
}

TEST(NeedleWay, TheScenesThemselvesAreGood) {
  EXPECT_EQ(refusal(pierced), "no error");
  EXPECT_EQ(refusal(stretched), "no error");
}

TEST(NeedleWay, StopsInFrontOfTheSkinInEveryDirection) {
  EXPECT_THAT(refusal(pierced, {motion("insert: {speed: 4 cm/s, position: 7 cm}")}),
              AllOf(StartsWith("test.yaml: override"), HasSubstr("needles.0.motion.0.insert'"),
                    HasSubstr("entry point at (0.06, 0.022) m"),
                    HasSubstr("0.01 m in front of the entry point")));
  // From the left and from below: positions grow against the advance there too.
  const std::vector<std::string> free = {"supports={right: fixed, top: fixed}"};
  for (const auto& [angle, height, inside, outside] :
       {std::tuple("0 rad", "-2.2 cm", "-2 cm", "2 cm"),
        std::tuple("90 degrees", "3.3 cm", "-2 cm", "2 cm")}) {
    auto with = free;
    with.insert(with.end(),
                {std::string("needle_angle=") + angle, std::string("needles.0.height=") + height});
    with.push_back(motion(std::string("insert: {speed: 4 cm/s, position: ") + inside + "}"));
    EXPECT_EQ(refusal(pierced, with), "no error") << angle;
    with.back() = motion(std::string("insert: {speed: 4 cm/s, position: ") + outside + "}");
    EXPECT_THAT(refusal(pierced, with), HasSubstr("in front of the entry point")) << angle;
  }
}

TEST(NeedleWay, GoesInByInsertAndOutByRetract) {
  EXPECT_THAT(refusal(pierced, {motion("insert: {speed: 1 cm/s, depth: 2 cm}, insert: {speed: 1 "
                                       "cm/s, position: 5 cm}")}),
              HasSubstr("key 'needles.0.motion.1.insert': needle 'needle1'"));
  EXPECT_THAT(refusal(pierced, {motion("insert: {speed: 1 cm/s, depth: 1 cm}, retract: {speed: 1 "
                                       "cm/s, position: 4 cm}")}),
              HasSubstr("deeper than the tip is then"));
}

TEST(NeedleWay, StaysInTheTissue) {
  EXPECT_THAT(refusal(pierced, {motion("insert: {speed: 4 cm/s, depth: 7 cm}")}),
              AllOf(HasSubstr("leaves the tissue at (0, 0.022) m"), Not(HasSubstr("again"))));
}

TEST(NeedleWay, IsAsLongAsTheTip) {
  EXPECT_EQ(refusal(pierced, {"needles.0.cutting.tip_length=4 cm"}), "no error");
  EXPECT_THAT(refusal(pierced, {"needles.0.cutting.tip_length=5 m"}),
              AllOf(HasSubstr("key 'needles.0.cutting.tip_length': 5 m is longer than the way"),
                    HasSubstr("through the tissue, 0.06 m")));
}

TEST(NeedleWay, MeetsNoLoadedCurveInTheTissue) {
  const std::vector<std::string> deep = {motion("insert: {speed: 4 cm/s, depth: 4 cm}")};
  const auto loaded = [&](const std::string& curve) {
    auto with = deep;
    with.push_back("loads.traction=[{curve: " + curve + ", force: [1 N/m, 0 N/m]}]");
    return refusal(pierced, with);
  };
  EXPECT_THAT(loaded("wall"),
              AllOf(HasSubstr("leads through curve 'wall' at (0.03, 0.022) m, which is loaded"),
                    HasSubstr("loads.traction.0")));
  EXPECT_EQ(loaded("right"), "no error");  // the skin
}

TEST(NeedleWay, MeetsNoCurveThatIsHeldOrMoved) {
  EXPECT_THAT(refusal(pierced, {"supports.right=roller"}),
              AllOf(HasSubstr("needles.0.height"),
                    HasSubstr("enters through curve 'right' at "
                              "(0.06, 0.022) m"),
                    HasSubstr("supports.right: roller")));
  EXPECT_THAT(
      refusal(pierced, {"supports.wall=fixed", motion("insert: {speed: 1 cm/s, depth: 4 cm}")}),
      HasSubstr("leads through curve 'wall' at (0.03, 0.022) m"));
  EXPECT_EQ(refusal(pierced, {"supports.wall=fixed"}), "no error");  // stops before it
  EXPECT_EQ(
      refusal(pierced, {"supports.wall=free", motion("insert: {speed: 1 cm/s, depth: 4 cm}")}),
      "no error");
  EXPECT_THAT(refusal(pierced, {"prescribed=[{curve: right, displacement: [null, 1 mm]}]"}),
              HasSubstr("is moved (prescribed.0)"));
  // The node that would slide to the axis is the end of a support.
  EXPECT_THAT(
      refusal(pierced, {"mesh.rectangle.curves.0={name: patch, points: [[6 cm, 3 cm], [6 cm, "
                        "4 cm]]}",
                        "supports.patch=fixed", "needles.0.height=2.9 cm"}),
      HasSubstr("next to a point that is held, (0.06, 0.03) m"));
}

TEST(NeedleWay, NeedlesDoNotPushAwayTissueThatNothingHolds) {
  EXPECT_THAT(refusal(pierced, {"supports={}"}),
              AllOf(HasSubstr("key 'supports'"), HasSubstr("moving along x"),
                    HasSubstr("would not come to rest")));
  EXPECT_THAT(refusal(pierced, {"supports={left: roller}"}), HasSubstr("moving along y"));
}

TEST(NeedleWay, ANeedleLeavesBeforeTheNextOneEnters) {
  const std::string second =
      ", {height: 1.2 cm, cutting: {cutting_force: 0.6 N}, motion: [insert: {speed: 4 cm/s, depth: "
      "1 cm}]}]";
  const std::string first =
      "needles=[{height: 2.2 cm, cutting: {cutting_force: 0.6 N}, motion: "
      "[insert: {speed: 4 cm/s, depth: 2 cm}";
  EXPECT_THAT(refusal(pierced, {first + "]}" + second}),
              HasSubstr("a retract all the way out at the end, because needle2 enters next"));
  EXPECT_EQ(refusal(pierced, {first + ", retract: {speed: 4 cm/s}]}" + second}), "no error");
}

TEST(Event, NoLengthIsNoMotion) {
  const auto error_of = [](const std::string& actions) {
    return placement_error(scene_of(pierced, {motion(actions)}));
  };
  const double error = error_of(
      "insert: {speed: 4 cm/s, depth: 2.5 cm}, implant: {}, retract: "
      "{speed: 4 cm/s}, settle: {}");
  EXPECT_EQ(
      error_of("insert: {speed: 4 cm/s, depth: 2.5 cm}, insert: {speed: 1 m/s, position: 3.5 "
               "cm}, retract: {speed: 1 cm/s, depth: 2.5 cm}, implant: {}, retract: {speed: 4 "
               "cm/s}, settle: {}"),
      error);
}

// 100 N is never reached: the whole way takes less than 4 N.
TEST(Event, ASeedOfANeedleThatNeverCutItsWayInHasNoPlacement) {
  EXPECT_THAT(
      message_of<NumericalError>(pierced, {"needles.0.cutting.cutting_force=100 N"}, true),
      AllOf(HasSubstr("has not cut its way in: its tip force reached"),
            HasSubstr("of the 100 N that are needed"), HasSubstr("after 25 mm of insertion")));
  EXPECT_THAT(message_of<NumericalError>(
                  pierced,
                  {"membrane={polygon: [[1 cm, 1 cm], [6 cm, 1 cm], [6 cm, 3 cm], [1 cm, 3 cm]], "
                   "puncture_force: 100 N}"},
                  true),
              HasSubstr("has not cut its way in"));
}

TEST(Event, AStopWithinTheFirstCutIsRefused) {
  // Elements of 5 mm: the first cut goes 2.5 mm.
  const std::string shallow = motion(
      "insert: {speed: 4 cm/s, depth: 1 mm}, implant: {}, retract: {speed: 4 cm/s}, settle: {}");
  EXPECT_THAT(message_of<NumericalError>(pierced, {shallow, "time.step=5 ms"}, true),
              HasSubstr("within its first cut"));
  EXPECT_EQ(message_of<NumericalError>(pierced, {shallow, "time.step=5 ms", "mesh.refine=2"}, true),
            "no error");
}

TEST(Event, AFailedOrUnfinishedRunHasNoPlacementError) {
  Simulation simulation(MPI_COMM_WORLD, scene_of(pierced), false);
  while (simulation.seeds().empty()) simulation.step();
  const auto seed = [&](const std::string& status) {
    return summarise(MPI_COMM_WORLD, simulation, status, {})["seeds"][0];
  };
  EXPECT_FALSE(seed("running").contains("placement_error"));
  EXPECT_FALSE(seed("failed").contains("placement_error"));
  EXPECT_TRUE(seed("completed").contains("placement_error"));
}

TEST(Event, UndampedTissueThatHasToSettleEndsTheRun) {
  EXPECT_THAT(message_of<NumericalError>(pierced,
                                         {"tissue.damping=null", "time.scheme=average_acceleration",
                                          "mesh.rectangle.columns=6", "mesh.rectangle.rows=4"},
                                         true),
              HasSubstr("the tissue does not come to rest"));
}

TEST(Contradiction, CurvesThatAreHeldAndMoved) {
  // Across a roller it acts, along its normal it would not.
  EXPECT_EQ(
      refusal(stretched, {"prescribed.0.curve=left", "prescribed.0.displacement=[null, 1 mm]"}),
      "no error");
  EXPECT_THAT(
      refusal(stretched, {"prescribed.0.curve=left", "prescribed.0.displacement=[1 mm, 1 mm]"}),
      AllOf(HasSubstr("key 'prescribed.0.displacement': would have no effect between (0, 0"),
            HasSubstr("where a support holds")));
  // A curve of another name along the same edges.
  EXPECT_THAT(refusal(stretched,
                      {"mesh.rectangle.curves=[{name: edge, points: [[0 cm, 0 cm], [0 cm, 2 cm]]}]",
                       "prescribed.0={curve: edge, displacement: [1 mm, null]}"}),
              HasSubstr("would have no effect"));
}

TEST(Contradiction, PointsOfTwoPrescribedCurves) {
  const std::string right = "prescribed=[{curve: right, displacement: [4 mm, null]}, ";
  EXPECT_THAT(refusal(stretched, {right + "{curve: top, displacement: [0 mm, 1 mm]}]"}),
              AllOf(HasSubstr("key 'prescribed.1.displacement': moves (0.04, 0.02) m"),
                    HasSubstr("a point of curve 'right' too, in another way than prescribed.0")));
  EXPECT_EQ(refusal(stretched, {right + "{curve: top, displacement: [null, 1 mm]}]"}), "no error");
  EXPECT_THAT(refusal(stretched, {"supports={left: fixed}",
                                  "prescribed=[{curve: right, displacement: [1 mm, 2 mm]}, "
                                  "{curve: top, displacement: [1 mm, 2 mm], ramp: 1 s}]",
                                  "time.duration=2 s"}),
              HasSubstr("the same displacement, start and ramp"));
}

TEST(Contradiction, ACornerThatASupportHoldsIsSaid) {
  const Simulation simulation(
      MPI_COMM_WORLD,
      scene_of(stretched, {"supports={bottom: fixed}", "prescribed.0.displacement=[1 mm, 0 mm]"}),
      false);
  EXPECT_THAT(
      notes_of(simulation),
      testing::ElementsAre(AllOf(HasSubstr("a support holds (0.04, 0) m"), HasSubstr("'right'"))));
}

TEST(Contradiction, TractionsThatWouldVanish) {
  const std::string none = "prescribed=[]";
  EXPECT_THAT(
      refusal(stretched, {none, "loads={traction: [{curve: left, force: [1 N/m, 0 N/m]}]}"}),
      HasSubstr("key 'loads.traction.0.force': would have no effect between"));
  EXPECT_EQ(refusal(stretched, {none, "loads={traction: [{curve: left, force: [0 N/m, 1 N/m]}]}"}),
            "no error");
  EXPECT_THAT(refusal(stretched, {"loads={traction: [{curve: right, force: [1 N/m, 0 N/m]}]}"}),
              HasSubstr("would have no effect"));
}

// Every number of a summary can be asked for, and no other.
TEST(Quantities, AreThoseOfTheSummary) {
  const auto numbers = [](const nlohmann::ordered_json& summary) {
    std::vector<std::string> paths;
    const auto flat = summary.flatten();
    for (const auto& [pointer, value] : flat.items()) {
      if (!value.is_number()) continue;
      std::string path = pointer.substr(1);
      std::ranges::replace(path, '/', '.');
      paths.push_back(path);
    }
    return paths;
  };
  for (const auto& scene :
       {scene_of(pierced, {"probes.p=[1 cm, 1 cm]"}),
        scene_of(stretched, {"probes.q=[1 cm, 1 cm]"}),
        scene_of(pierced, {"time.method=explicit", "tissue.damping={mass_factor: 100 1/s}",
                           motion("insert: {speed: 4 cm/s, depth: 2 mm}")})}) {
    Simulation simulation(MPI_COMM_WORLD, scene, false);
    run_to_end(simulation);
    std::vector<std::string> known;
    for (const auto& quantity : summary_quantities(scene)) {
      known.push_back(quantity.path);
      EXPECT_EQ(unit_of_quantity(quantity.path), quantity.unit);
    }
    EXPECT_THAT(numbers(summarise(MPI_COMM_WORLD, simulation, "completed", {})),
                testing::UnorderedElementsAreArray(known));
  }
}

}  // namespace
}  // namespace stylet
