#include "stylet/base/errors.hpp"
#include "stylet/study/campaign_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stylet {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string scene = R"(
needles:
  - height: 3.2 cm
    friction: {static_force: 200 N/m, kinetic_force: 100 N/m}
    motion:
      - insert: {speed: 2 cm/s, position: 3.5 cm}
      - implant: {target: a}
targets:
  a: [3.5 cm, 3.2 cm]
time: {step: 5 ms}
)";

CampaignPlan planned(const std::string& campaign) {
  const auto loaded =
      load_campaign("c.yaml", "scene: s.yaml\noutputs: [seeds.0.placement_error]\n" + campaign, {});
  return plan_runs(loaded, parse_yaml("s.yaml", scene));
}

std::string refusal(const std::string& campaign) {
  try {
    (void)planned(campaign);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Campaign, GridOfValuesAndRange) {
  const auto plan = planned(R"(
design: grid
vary:
  height: {key: needles.0.height, from: 3 cm, to: 34 mm, count: 3}
  plane: {key: tissue.plane, values: [stress, strain]}
)");
  EXPECT_THAT(plan.units, ElementsAre("cm", ""));
  ASSERT_EQ(plan.runs.size(), 6U);
  EXPECT_THAT(plan.runs[0].overrides, ElementsAre("needles.0.height=3 cm", "tissue.plane=stress"));
  EXPECT_THAT(plan.runs[3].overrides,
              ElementsAre("needles.0.height=3.2 cm", "tissue.plane=strain"));
}

TEST(Campaign, TextsThatBeginWithANumberHaveNoUnit) {
  const auto units = [](const std::string& variable) {
    return planned("design: grid\nvary:\n  v: " + variable + "\n").units;
  };
  EXPECT_THAT(units("{key: mesh.file, values: [1.msh, coarse.msh]}"), ElementsAre(""));
  EXPECT_THAT(units("{key: mesh.file, values: [2mm.msh]}"), ElementsAre(""));
  EXPECT_THAT(units("{key: needles.0.height, values: [2mm]}"), ElementsAre("mm"));
  EXPECT_THAT(
      refusal("design: grid\nvary: {v: {offset_of: [needles.0.height], values: [1 foo]}}\n"),
      HasSubstr("unknown unit 'foo'"));
}

TEST(Campaign, FactorsPowersAndOffsetsAreRelativeToTheScene) {
  const auto plan = planned(R"(
design: grid
vary:
  speed: {factor_of: {needles.0.motion.0.speed: 1, time.step: -1}, values: [2]}
  depth: {offset_of: [needles.0.motion.0.position], values: [-5 mm]}
)");
  EXPECT_THAT(plan.runs[0].overrides,
              ElementsAre("needles.0.motion.0.insert.speed=4 cm/s", "time.step=2.5 ms",
                          "needles.0.motion.0.insert.position=3 cm"));
}

TEST(Campaign, OneAtATimeStartsWithTheSceneAsItIs) {
  const auto plan = planned(R"(
vary:
  height: {key: needles.0.height, values: [3 cm, 3.4 cm]}
  friction: {factor_of: {needles.0.friction.static_force: 1}, values: [0.5, 2]}
)");
  ASSERT_EQ(plan.points.size(), 5U);
  EXPECT_THAT(plan.points[0].values, ElementsAre("3.2 cm", "1"));
  EXPECT_THAT(plan.points[4].values, ElementsAre("3.2 cm", "2"));
}

TEST(Campaign, WindowsShiftWhatThePointSets) {
  const auto plan = planned(R"(
design: grid
vary:
  height: {key: needles.0.height, values: [3 cm]}
average:
  jitter: {offset_of: [needles.0.height, targets.a.1], width: 2 mm, count: 3}
)");
  ASSERT_EQ(plan.runs.size(), 3U);
  EXPECT_THAT(plan.runs[0].overrides, ElementsAre("needles.0.height=2.9 cm", "targets.a.1=3.1 cm"));
  EXPECT_THAT(plan.runs[1].overrides, ElementsAre("needles.0.height=3 cm", "targets.a.1=3.2 cm"));
}

TEST(Campaign, TwoOfOneKeyAreRefused) {
  const auto both = [](const std::string& a, const std::string& b, const std::string& more = "") {
    return refusal("design: grid\nvary:\n  a: " + a + "\n  b: " + b + "\n" + more);
  };
  const std::string height = "{key: needles.0.height, values: [3 cm]}";
  EXPECT_THAT(both(height, "{key: needles.0.height, values: [2 cm]}"),
              HasSubstr("key 'vary.b': changes 'needles.0.height', and 'a' changes it too"));
  EXPECT_THAT(both(height, "{offset_of: [needles.0.height], values: [1 mm]}"),
              HasSubstr("changes it too"));
  EXPECT_THAT(both("{key: needles.0.friction, values: [x]}",
                   "{factor_of: {needles.0.friction.static_force: 1}, values: [2]}"),
              HasSubstr("changes 'needles.0.friction.static_force', and 'a' changes "
                        "'needles.0.friction'"));
  // The same key in two spellings.
  EXPECT_THAT(both("{key: needles.0.motion.0.speed, values: [1 cm/s]}",
                   "{key: needles.0.motion.0.insert.speed, values: [2 cm/s]}"),
              HasSubstr("changes it too"));
  EXPECT_THAT(
      both("{offset_of: [time.step], values: [1 ms]}", "{factor_of: {time.step: 1}, values: [2]}"),
      HasSubstr("changes it too"));
  EXPECT_EQ(
      both("{factor_of: {time.step: 1}, values: [3]}", "{factor_of: {time.step: -1}, values: [2]}"),
      "accepted");
  EXPECT_EQ(both(height, "{key: time.step, values: [1 ms]}",
                 "average:\n  w: {offset_of: [needles.0.height], width: 1 mm, count: 2}\n"),
            "accepted");
  EXPECT_THAT(both("{key: needles.0.motion.0.position, values: [3 cm], on_the_way: true}",
                   "{key: needles.0.motion.0.speed, values: [1 cm/s]}"),
              HasSubstr("on_the_way makes many inserts of one"));
}

TEST(Campaign, WindowsShiftAKeyInAnySpelling) {
  const auto plan = planned(R"(
design: grid
vary:
  position: {key: needles.0.motion.0.position, values: [3 cm]}
average:
  jitter: {offset_of: [needles.0.motion.0.insert.position], width: 2 mm, count: 2}
)");
  EXPECT_THAT(plan.runs[0].overrides, ElementsAre("needles.0.motion.0.insert.position=2.9 cm"));
}

TEST(Campaign, SeedsOnTheWayShareOneRun) {
  const auto plan = planned(R"(
design: grid
vary:
  position: {key: needles.0.motion.0.position, values: [3 cm, 4 cm], on_the_way: true}
  friction: {factor_of: {needles.0.friction.static_force: 1}, values: [1, 2]}
)");
  ASSERT_EQ(plan.runs.size(), 2U);
  EXPECT_THAT(plan.runs[0].overrides.front(), HasSubstr("position: 4 cm"));
  // The needle comes from the right: 4 cm is reached first.
  EXPECT_EQ(plan.points[plan.runs[0].points[0]].values[0], "4 cm");
  EXPECT_THAT(plan.runs[0].outputs, ElementsAre(ElementsAre("seeds.0.placement_error"),
                                                ElementsAre("seeds.1.placement_error")));
}

TEST(Campaign, Refusals) {
  EXPECT_THAT(refusal("vary: {}\n"), HasSubstr("at least one variable"));
  EXPECT_THAT(refusal("vary: {a: {key: time.step, values: [1 ms], from: 1 ms}}\n"),
              HasSubstr("either values, or from and to"));
  EXPECT_THAT(refusal("design: morris\nvary: {a: {key: time.step, from: 1 ms, to: 2 ms}}\n"),
              HasSubstr("samples"));
  EXPECT_THAT(refusal("vary: {a: {key: time.step, from: 1 ms, to: 2 m, count: 3}}\n"),
              HasSubstr("not convertible"));
  EXPECT_THAT(refusal("vary: {a: {factor_of: {time.safety: 1}, values: [2]}}\n"),
              HasSubstr("does not write 'time.safety'"));
  EXPECT_THAT(refusal("vary: {a: {key: needles.0.height, values: [3 cm], on_the_way: true}}\n"),
              HasSubstr("on_the_way"));
  EXPECT_THAT(
      refusal(
          "design: grid\nvary: {a: {key: needles.0.height, values: [3 cm], on_the_way: true}}\n"),
      HasSubstr("followed by an implant"));
}

TEST(Campaign, HugeOnesAreRefusedBeforeTheyArePlanned) {
  const std::string range = "vary: {x: {key: time.step, from: 1 ms, to: 2 ms}}\n";
  for (const char* design : {"random", "latin_hypercube", "morris", "sobol"}) {
    EXPECT_THAT(refusal(range + "samples: 1000000000\ndesign: " + design + "\n"),
                HasSubstr("c.yaml:4:10: key 'samples': value '1000000000' makes "));
  }
  EXPECT_THAT(refusal("design: grid\nvary:\n"
                      "  x: {key: time.step, from: 1 ms, to: 2 ms, count: 1000}\n"
                      "  y: {key: needles.0.height, from: 1 cm, to: 2 cm, count: 1000}\n"),
              HasSubstr("c.yaml:4:1: key 'vary'"));
  EXPECT_THAT(refusal("vary: {x: {key: time.step, from: 1 ms, to: 2 ms, count: 2000000000}}\n"),
              HasSubstr("allowed: at most 100000 in all"));
  EXPECT_THAT(
      refusal("vary: {x: {key: time.step, values: [1 ms]}}\n"
              "average: {w: {offset_of: [needles.0.height], width: 1 mm, count: 500000}}\n"),
      HasSubstr("makes 1e+06 points"));
}

TEST(Campaign, NamesWithDotsStandInQuotes) {
  const Node dotted = parse_yaml(
      "s.yaml",
      R"(tissue: {regions: {lobe.left: {youngs_modulus: 60 kPa}, lobe.right: {youngs_modulus: 60 kPa}}})");
  const auto campaign = load_campaign("c.yaml", R"(
scene: s.yaml
outputs: ['probes."a.b".0']
vary:
  "my.modulus": {key: '"tissue".regions."lobe.left".youngs_modulus', values: [50 kPa]}
  factor: {factor_of: {tissue.regions."lobe.right".youngs_modulus: 1}, values: [2]}
)",
                                      {});
  const auto plan = plan_runs(campaign, dotted);
  EXPECT_THAT(plan.runs[0].overrides,
              Contains(R"(tissue.regions."lobe.left".youngs_modulus=60 kPa)"));
  EXPECT_THAT(plan.runs[2].overrides,
              Contains(R"(tissue.regions."lobe.right".youngs_modulus=120 kPa)"));
  EXPECT_THAT(campaign.outputs, ElementsAre(R"(probes."a.b".0)"));
  EXPECT_THAT(refusal(R"(vary: {x: {key: 'tissue."regions', values: [1]}})"),
              HasSubstr("a quote that is not closed"));
}

TEST(Campaign, ManySeedsOnTheWayAreOneRun) {
  const auto plan = planned(R"(
design: grid
vary:
  depth: {key: needles.0.motion.0.position, from: 3.5 cm, to: 1 cm, count: 5000, on_the_way: true}
)");
  ASSERT_EQ(plan.runs.size(), 1U);
  EXPECT_EQ(plan.runs[0].points.size(), 5000U);
}

}  // namespace
}  // namespace stylet
