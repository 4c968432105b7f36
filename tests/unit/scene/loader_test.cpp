// Reading single keys. Messages name file, line, key, value and what is allowed.
#include "stylet/scene/loader.hpp"

#include "example.hpp"
#include <gmock/gmock.h>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

TEST(Loader, ReadsSiUnitsNamesAndFileOrder) {
  const Scene scene = load_scene("input/scene.yaml", needle_scene);
  EXPECT_EQ(scene.file, "input/scene.yaml");
  EXPECT_EQ(std::get<std::string>(scene.mesh.source), "block.msh");
  ASSERT_EQ(scene.tissue.regions.size(), 2u);
  EXPECT_EQ(scene.tissue.regions[0].region, "prostate");
  EXPECT_EQ(scene.tissue.regions[0].material.youngs_modulus, 60000.0);
  EXPECT_EQ(scene.tissue.regions[1].region, "surrounding");
  ASSERT_EQ(scene.supports.size(), 2u);
  EXPECT_EQ(scene.supports[0].curve, "left");
  EXPECT_EQ(scene.supports[1].kind, SupportKind::roller);
  ASSERT_EQ(scene.needles.size(), 1u);
  const NeedleParameters& needle = scene.needles[0];
  EXPECT_EQ(needle.height, 0.032);
  EXPECT_EQ(needle.friction->slip_speed, 0.0015);
  ASSERT_EQ(needle.motion.size(), 4u);
  EXPECT_EQ(needle.motion[0].depth, 0.04);
  EXPECT_FALSE(needle.motion[0].position);
  EXPECT_EQ(needle.motion[2].kind, ActionKind::retract);
  EXPECT_EQ(needle.motion[3].duration, 1.0);
  EXPECT_EQ(scene.targets[0].point, (ReferencePoint{0.035, 0.032}));
}

TEST(Loader, FillsInDefaultsThatDependOnOtherKeys) {
  const Scene scene = load_scene("s.yaml", needle_scene);
  EXPECT_EQ(scene.needles[0].name, "needle1");
  EXPECT_EQ(scene.needles[0].motion[1].target, "seed");
  EXPECT_EQ(scene.needles[0].cutting.law, CuttingLaw::consistent);
  EXPECT_EQ(scene.tissue.mass, MassKind::consistent);
  EXPECT_FALSE(scene.time.until_implanted);
  const Scene fast = load_scene("s.yaml", needle_scene, {"time.method=explicit"});
  EXPECT_EQ(fast.needles[0].cutting.law, CuttingLaw::lagged);
  EXPECT_EQ(fast.tissue.mass, MassKind::lumped);
  const Scene block = load_scene("s.yaml", block_scene, {"time.step=2 s"});
  EXPECT_EQ(block.time.duration, 2.0);
}

TEST(Loader, UnknownKeysNameTheNearestKnownKey) {
  EXPECT_THAT(message_of(changed(needle_scene, "plane", "plain")),
              AllOf(StartsWith("scene.yaml:3:10: key 'tissue.plain': value 'stress'"),
                    HasSubstr("nearest known key is 'plane'"), HasSubstr("allowed: plane, ")));
  EXPECT_THAT(message_of(needle_scene + "loads: {bodi: []}\n"), HasSubstr("'body'"));
  EXPECT_THAT(message_of(changed(needle_scene, "insert:", "inject:")),
              HasSubstr("allowed: one of insert, hold, implant, retract, settle"));
}

TEST(Loader, ChoicesListWhatIsAllowed) {
  EXPECT_EQ(message_of(changed(needle_scene, "plane: stress", "plane: foo")),
            "scene.yaml:3:10: key 'tissue.plane': value 'foo'; allowed: stress, strain");
  EXPECT_THAT(message_of(changed(needle_scene, "top: roller", "top: hinged")),
              HasSubstr("key 'supports.top': value 'hinged'; allowed: fixed, roller, free"));
}

TEST(Loader, NumbersNeedTheRightUnit) {
  EXPECT_EQ(message_of(changed(needle_scene, "3.2 cm\n", "0.032\n")),
            "scene.yaml:9:13: key 'needles.0.height': value '0.032' needs a unit, such as mm; "
            "allowed: a number with a unit, such as mm");
  EXPECT_THAT(message_of(changed(needle_scene, "1.7 N", "0")),
              HasSubstr("value '0' needs a unit, such as N; allowed: a number with a unit"));
  EXPECT_THAT(message_of(changed(needle_scene, "60 kPa", "60 mm")),
              HasSubstr("value '60 mm' is not convertible to Pa"));
  EXPECT_THAT(
      message_of(changed(needle_scene, "0.49", "0.49 m")),
      HasSubstr("value '0.49 m' has 'm' behind its number; allowed: a number without a unit"));
  EXPECT_THAT(message_of(changed(needle_scene, "[3.5 cm, 3.2 cm]", "[3.5 cm]")),
              HasSubstr("key 'targets.seed': value '[3.5 cm]'; allowed: [x, y], each a number"));
  EXPECT_THAT(message_of(changed(needle_scene, "[3.5 cm, 3.2 cm]", "[3.5 cm, 3]")),
              HasSubstr("key 'targets.seed.1': value '3' needs a unit"));
}

TEST(Loader, RangesAreChecked) {
  EXPECT_THAT(message_of(changed(needle_scene, "60 kPa", "0 kPa")),
              AllOf(StartsWith("scene.yaml:5:32: key 'tissue.regions.prostate.youngs_modulus'"),
                    HasSubstr("value '0 kPa'; allowed: "), HasSubstr("> 0 Pa")));
  EXPECT_THAT(message_of(changed(needle_scene, "0.49", "0.5")),
              HasSubstr("value '0.5'; allowed: a number without a unit, >= 0 and < 0.5 "
                        "(0.5 is incompressible: take 0.4999)"));
  EXPECT_THAT(message_of(changed(needle_scene, "0.49", "-0.1")), HasSubstr(">= 0 and < 0.5"));
  for (const char* value : {"0", "1.01"}) {
    const std::string sharpness = std::string("needles.0.cutting.sharpness=") + value;
    EXPECT_THAT(message_of(needle_scene, {sharpness}), HasSubstr("> 0 and <= 1"));
  }
  EXPECT_THAT(message_of(needle_scene, {"needles.0.friction.kinetic_force=-1 N/m"}),
              HasSubstr(">= 0 N/m"));
  EXPECT_THAT(message_of(block_scene, {"mesh.rectangle.rows=0"}), HasSubstr("a whole number >= 1"));
  EXPECT_THAT(message_of(block_scene, {"mesh.rectangle.rows=2.5"}), HasSubstr("a whole number"));
  EXPECT_THAT(message_of(block_scene, {"output.history=maybe"}), HasSubstr("true, false"));
}

TEST(Loader, MissingKeysAreNamed) {
  EXPECT_EQ(message_of(changed(block_scene, "  plane: strain\n", "")),
            "scene.yaml:2:1: key 'tissue.plane': missing; allowed: stress, strain");
  EXPECT_EQ(
      message_of(changed(needle_scene, "  plane: stress\n", "")),
      "scene.yaml:2:1: key 'tissue.plane': missing; allowed: stress, strain, because the scene's "
      "needles have height; in space they have entry");
  EXPECT_THAT(message_of(changed(needle_scene, "cutting_force: 1.7 N", "sharpness: 1")),
              HasSubstr("key 'needles.0.cutting.cutting_force': missing; allowed: a number with a "
                        "unit, such as N, > 0 N"));
  EXPECT_THAT(message_of(""), HasSubstr("allowed: a block of mesh, tissue"));
  EXPECT_THAT(message_of("mesh: {file: a}\n"),
              HasSubstr("key 'tissue': missing; allowed: a block"));
}

TEST(Loader, ExclusiveKeysAreCounted) {
  EXPECT_THAT(message_of(changed(needle_scene, "{file: block.msh}", "{refine: 1}")),
              AllOf(StartsWith("scene.yaml:1:1: key 'mesh': value '{refine: 1}'"),
                    HasSubstr("allowed: exactly one of file, rectangle")));
  EXPECT_THAT(message_of(block_scene, {"mesh.file=a.msh"}),
              HasSubstr("exactly one of file, rectangle"));
  EXPECT_THAT(message_of(changed(needle_scene, ", depth: 4 cm", "")),
              HasSubstr("exactly one of depth, position"));
  EXPECT_THAT(message_of(needle_scene, {"needles.0.motion.0.position=3 cm"}),
              HasSubstr("exactly one of depth, position"));
  EXPECT_THAT(message_of(needle_scene, {"membrane.puncture_force=1 N"}),
              HasSubstr("exactly one of region, surface, polygon"));
  EXPECT_THAT(message_of(needle_scene, {"needles.0.motion.3.speed_tolerance=1 mm/s"}),
              HasSubstr("at most one of duration, speed_tolerance"));
  const std::string region = "mesh.rectangle.inner_regions=[{name: a}]";
  EXPECT_THAT(message_of(block_scene, {region}), HasSubstr("exactly one of ellipse, polygon"));
}

TEST(Loader, PrescribedComponentsMayBeNull) {
  const Scene scene =
      load_scene("s.yaml", block_scene,
                 {"prescribed=[{curve: right, displacement: [null, -1 mm], ramp: 1 s}]"});
  EXPECT_FALSE(scene.prescribed[0].displacement[0]);
  EXPECT_EQ(scene.prescribed[0].displacement[1], -0.001);
}

TEST(Loader, ExpectationsTakeAnyUnitOfTheirQuantity) {
  const Scene scene =
      load_scene("s.yaml", block_scene,
                 {"probes.p=[1 cm, 1 cm]", "expect=[{quantity: probes.p.0, min: 5.5 mm, max: 7}]"});
  EXPECT_EQ(scene.expect[0].min, 0.0055);
  EXPECT_EQ(scene.expect[0].max, 7.0);
  EXPECT_THAT(message_of(block_scene, {"expect=[{quantity: time, min: 5.5 K}]"}),
              HasSubstr("key 'expect.0.min': value '5.5 K' is not convertible to s"));
}

}  // namespace
}  // namespace stylet
