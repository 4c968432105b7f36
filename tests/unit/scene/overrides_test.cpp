#include "example.hpp"
#include <gmock/gmock.h>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

Scene with(const std::vector<std::string>& overrides) {
  return load_scene("scene.yaml", needle_scene, overrides);
}

TEST(Overrides, ReplaceValuesAnywhere) {
  const Scene scene =
      with({"tissue.regions.prostate.youngs_modulus=80 kPa", "needles.0.motion.0.depth=5 cm",
            "needles.0.motion.2.retract.speed = 1 cm/s", "supports.top=fixed", "time.step=0.5 ms",
            "targets.seed=[1 cm, 2 cm]"});
  EXPECT_EQ(scene.tissue.regions[0].material.youngs_modulus, 80000.0);
  EXPECT_EQ(scene.tissue.regions[1].material.youngs_modulus, 40000.0);
  EXPECT_EQ(scene.needles[0].motion[0].depth, 0.05);
  EXPECT_EQ(scene.needles[0].motion[2].speed, 0.01);
  EXPECT_EQ(scene.supports[1].kind, SupportKind::fixed);
  EXPECT_EQ(scene.time.step, 0.0005);
  EXPECT_EQ(scene.targets[0].point, (ReferencePoint{0.01, 0.02}));
}

TEST(Overrides, MakeBlocksThatAreNotThere) {
  const Scene scene =
      with({"output.snapshots=50 ms", "probes.tip=[1 cm, 1 cm]", "needles.0.motion.1.target=seed",
            "tissue.damping={stiffness_factor: 1 s}"});
  EXPECT_EQ(scene.output.snapshots, 0.05);
  EXPECT_EQ(scene.probes[0].name, "tip");
  EXPECT_EQ(scene.tissue.damping->stiffness_factor, 1.0);
}

TEST(Overrides, TheLastOneHolds) {
  EXPECT_EQ(with({"time.step=1 s", "time.step=2 s"}).time.step, 2.0);
}

TEST(Overrides, NullOfAnAbsentKeyChangesNothing) {
  EXPECT_EQ(message_of(needle_scene, {"output.snapshots=null"}), "no error");
  EXPECT_EQ(message_of(block_scene, {"tissue.damping.mass_factor=null"}), "no error");
  EXPECT_THAT(message_of(needle_scene, {"output.snapshot=null"}), HasSubstr("unknown key"));
}

TEST(Overrides, NullRemovesAKey) {
  EXPECT_FALSE(with({"needles.0.friction=null"}).needles[0].friction);
  const Scene scene = with({"needles.0.motion.0.depth=null", "needles.0.motion.0.position=3 cm"});
  EXPECT_EQ(scene.needles[0].motion[0].position, 0.03);
  EXPECT_EQ(message_of(block_scene, {"tissue.plane=null"}),
            "scene.yaml:2:1: key 'tissue.plane': missing; allowed: stress, strain");
}

TEST(Overrides, NullWhereNothingIsChangesNothing) {
  EXPECT_FALSE(with({"output.snapshots=null", "membrane.region=null"}).membrane);
  EXPECT_FALSE(with({"probes.tip=null"}).output.snapshots);
  EXPECT_THAT(message_of(needle_scene, {"output.snapshot=null"}),
              HasSubstr("nearest known key is 'output.snapshots'"));
  EXPECT_THAT(message_of(needle_scene, {"needles.4.friction=null"}), HasSubstr("1 items"));
}

TEST(Overrides, NamesWithDotsStandInQuotes) {
  std::string scene = needle_scene;
  const auto at = scene.find("prostate:");
  scene.replace(at, 8, "lobe.left");
  const auto loaded = load_scene("s", scene,
                                 {R"(tissue.regions."lobe.left".youngs_modulus=80 kPa)",
                                  R"(probes."a \"b\".c=d"=[1 cm, 1 cm])", R"("time"."step"=2 s)"});
  EXPECT_EQ(loaded.tissue.regions[0].material.youngs_modulus, 80000.0);
  EXPECT_EQ(loaded.probes[0].name, "a \"b\".c=d");
  EXPECT_EQ(loaded.time.step, 2.0);
  EXPECT_THAT(message_of(scene, {"tissue.regions.lobe.left.density=1 kg/m^3"}),
              HasSubstr(R"(double quotes: tissue.regions."lobe.left")"));
  EXPECT_THAT(message_of(scene, {R"(tissue.regions."lobe.left.density=1 kg/m^3)"}),
              HasSubstr("no closing quote"));
  EXPECT_THAT(message_of(scene, {R"(tissue.regions."lobe.left".density=1 m)"}),
              HasSubstr(R"(key 'tissue.regions."lobe.left".density')"));
}

TEST(Overrides, TheirTextIsNotKeptWithEveryValue) {
  // 4 MB of items; with all of the text beside each of them it would be 10^12 bytes.
  std::string list = "probes={";
  for (int i = 0; i < 20000; ++i) list += "p" + std::to_string(i) + ": [1 cm, 1 cm], ";
  EXPECT_EQ(with({list + "}"}).probes.size(), 20000U);
}

TEST(Overrides, StrayCommasAndBracketsEnd) {
  for (const char* text : {",5 ms", "]", "}", "5 ms\n]", "{a: 1}}", "- 1\n, 2"}) {
    EXPECT_THAT(message_of(needle_scene, {std::string("time.step=") + text}),
                StartsWith("scene.yaml: override 'time.step="))
        << text;
  }
}

TEST(Overrides, MessagesNameTheOverride) {
  EXPECT_EQ(message_of(needle_scene, {"tissue.plane=foo"}),
            "scene.yaml: override 'tissue.plane=foo': key 'tissue.plane': value 'foo'; allowed: "
            "stress, strain");
  EXPECT_THAT(message_of(needle_scene, {"needles.0.friction.slip_speed=1 mm/s"}),
              AllOf(StartsWith("scene.yaml: override 'needles.0"), HasSubstr("> stick_speed")));
  EXPECT_THAT(message_of(needle_scene, {"time.step=[1"}), HasSubstr("not valid YAML"));
  EXPECT_THAT(message_of(needle_scene, {"time.step"}), HasSubstr("key=value"));
  EXPECT_THAT(message_of(needle_scene, {"=1"}), HasSubstr("key=value"));
  EXPECT_THAT(message_of(needle_scene, {"time.step="}), HasSubstr("key=value"));
}

TEST(Overrides, UnknownKeysNameTheNearestKnownKey) {
  EXPECT_THAT(
      message_of(needle_scene, {"time.stp=1 s"}),
      AllOf(HasSubstr("key 'time.stp': unknown key for value '1 s'"),
            HasSubstr("the nearest known key is 'time.step'"), HasSubstr("allowed: method")));
  EXPECT_THAT(message_of(needle_scene, {"step=1 s"}), HasSubstr("'time.step'"));
  EXPECT_THAT(message_of(needle_scene, {"needles.0.motion.0.dept=1 cm"}),
              HasSubstr("'needles.0.motion.0.insert.depth'"));
  EXPECT_THAT(message_of(needle_scene, {"needles.3.height=1 cm"}),
              HasSubstr("one of the 1 items of 'needles'"));
  EXPECT_THAT(message_of(needle_scene, {"time.step.x=1"}), HasSubstr("'time.step'"));
  EXPECT_THAT(message_of(needle_scene, {"needles.0.motion.9.depth=1 cm"}), HasSubstr("4 items"));
}

}  // namespace
}  // namespace stylet
