// The rules that tie several keys together.
#include "stylet/scene/check.hpp"

#include "example.hpp"
#include <gmock/gmock.h>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

TEST(Check, TheExamplesAreValid) {
  EXPECT_EQ(message_of(needle_scene), "no error");
  EXPECT_EQ(message_of(block_scene), "no error");
  EXPECT_NO_THROW(check(load_scene("s.yaml", needle_scene)));
}

TEST(Check, DensityMayBeZeroOnlyIfQuasiStatic) {
  EXPECT_EQ(message_of(block_scene, {"time.method=implicit", "time.duration=1 s"}),
            "scene.yaml:4:75: key 'tissue.regions.tissue.density': value '0 kg/m^3'; allowed: > 0 "
            "kg/m^3 unless time.method is quasi_static");
}

TEST(Check, FrictionLimitsAndSpeedsAreOrdered) {
  EXPECT_EQ(message_of(changed(needle_scene, "195", "100")),
            "scene.yaml:11:30: key 'needles.0.friction.static_force': value '100 N/m'; allowed: >= "
            "kinetic_force, which is 130 N/m");
  EXPECT_THAT(message_of(changed(needle_scene, "1.5 mm/s", "1 mm/s")),
              HasSubstr("slip_speed': value '1 mm/s'; allowed: > stick_speed, which is 0.001 m/s"));
}

TEST(Check, StepIsNoLongerThanTheScene) {
  const std::vector<std::string> dynamic = {"time.method=implicit", "time.duration=1 s",
                                            "tissue.regions.tissue.density=1 kg/m^3"};
  auto all = dynamic;
  all.emplace_back("time.step=2 s");
  EXPECT_THAT(
      message_of(block_scene, all),
      HasSubstr("key 'time.step': value '2 s'; allowed: at most time.duration, which is 1 s"));
}

TEST(Check, CuttingLawFitsTheMethod) {
  EXPECT_THAT(
      message_of(needle_scene, {"time.method=explicit", "needles.0.cutting.law=consistent"}),
      HasSubstr("value 'consistent'; allowed: lagged, increment, because"));
  EXPECT_THAT(message_of(needle_scene, {"needles.0.cutting.law=increment"}),
              HasSubstr("key 'needles.0.cutting.increment': missing; allowed: a length > 0 m"));
  EXPECT_THAT(message_of(needle_scene, {"needles.0.cutting.stiffness_share=0.5"}),
              HasSubstr("reference_youngs_modulus': missing; allowed: a stiffness > 0 Pa"));
}

TEST(Check, ExplicitNeedsLumpedMass) {
  EXPECT_THAT(message_of(needle_scene, {"time.method=explicit", "tissue.mass=consistent"}),
              HasSubstr("key 'tissue.mass': value 'consistent'; allowed: lumped, because"));
}

TEST(Check, MotionStartsWithInsert) {
  EXPECT_THAT(message_of(needle_scene, {"needles.0.motion=[{hold: {duration: 1 s}}]"}),
              AllOf(HasSubstr("key 'needles.0.motion.0'"), HasSubstr("insert comes first")));
  EXPECT_THAT(message_of(needle_scene, {"needles.0.motion=[]"}), HasSubstr("at least one action"));
  EXPECT_THAT(message_of(needle_scene, {"needles.0.motion=null"}), HasSubstr("motion': missing"));
}

TEST(Check, ImplantNamesATarget) {
  EXPECT_THAT(message_of(changed(needle_scene, "- implant", "- implant: {target: sed}")),
              HasSubstr("motion.1.implant.target': value 'sed'; allowed: seed"));
  EXPECT_THAT(message_of(needle_scene, {"targets.other=[1 cm, 1 cm]"}),
              HasSubstr("implant.target': missing; allowed: seed, other"));
  EXPECT_THAT(message_of(needle_scene, {"targets=null"}), HasSubstr("targets, which is empty"));
}

TEST(Check, NothingIsImplantedOutsideTheTissue) {
  const std::string motion = changed(needle_scene, "- settle: {duration: 1 s}", "- implant");
  EXPECT_THAT(message_of(motion),
              AllOf(StartsWith("scene.yaml:16:9"), HasSubstr("all the way out")));
  EXPECT_THAT(
      message_of(changed(needle_scene, "- settle: {duration: 1 s}", "- retract: {speed: 1 m/s}")),
      HasSubstr("no retract once"));
}

TEST(Check, DurationIsOfScenesWithoutNeedles) {
  EXPECT_THAT(message_of(needle_scene, {"time.duration=1 s"}),
              HasSubstr("key 'time.duration': value '1 s'; allowed: only in a scene without"));
  EXPECT_THAT(
      message_of(block_scene, {"time.method=implicit", "tissue.regions.tissue.density=1 kg/m^3"}),
      HasSubstr("key 'time.duration': missing; allowed: > 0 s"));
}

TEST(Check, StoppingAtTheLastImplantHasToBeExact) {
  const std::vector<std::string> early = {"time.until=implanted"};
  const std::string rests = changed(needle_scene, "- settle: {duration: 1 s}", "- settle");
  EXPECT_EQ(message_of(rests, early), "no error");
  const auto with = [&](const std::string& change) {
    return message_of(rests, {early[0], change});
  };
  for (const char* load : {"loads={body: [{force: [0 N/m^3, -1 N/m^3]}]}",
                           "loads={traction: [{curve: right, force: [1 N/m, 0 N/m]}]}",
                           "prescribed=[{curve: right, displacement: [1 mm, 0 mm]}]"}) {
    EXPECT_THAT(with(load), HasSubstr("allowed: settled, because")) << load;
    EXPECT_THAT(with(load), HasSubstr(" lasts")) << load;
  }
  EXPECT_EQ(with("loads={body: [{force: [0 N/m^3, 0 N/m^3]}]}"), "no error");
  EXPECT_EQ(with("prescribed=[{curve: right, displacement: [0 mm, 0 mm]}]"), "no error");
  EXPECT_THAT(message_of(needle_scene, early), HasSubstr("does not end with a settle"));
  EXPECT_THAT(message_of(changed(rests, "      - settle\n", ""), early),
              HasSubstr("does not end with a settle"));
  EXPECT_THAT(message_of(changed(rests, "retract: {", "retract: {depth: 1 cm, "), early),
              HasSubstr("not all the way out"));
  const std::string late = changed(needle_scene, "- settle: {duration: 1 s}", "- implant");
  EXPECT_THAT(message_of(changed(late, "retract: {", "retract: {depth: 1 cm, "), early),
              HasSubstr("key 'time.until': value 'implanted'; allowed: settled, because needle1"));
  EXPECT_THAT(message_of(changed(needle_scene, "      - implant\n", ""), early),
              HasSubstr("no needle implants"));
  EXPECT_THAT(message_of(block_scene, early), HasSubstr("no needle implants"));
}

TEST(Check, NamesAreUnique) {
  const Scene scene = load_scene("s.yaml", needle_scene);
  const auto refusal = [](const Scene& twice) -> std::string {
    try {
      check(twice);
      return "no error";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  Scene twice = scene;
  twice.needles.push_back(twice.needles[0]);
  EXPECT_THAT(refusal(twice),
              HasSubstr("key 'needles.1.name': value 'needle1'; allowed: a name that"));
  twice = scene;
  twice.tissue.regions.push_back(twice.tissue.regions[0]);
  EXPECT_THAT(refusal(twice), HasSubstr("key 'tissue.regions.prostate'"));
  twice = scene;
  twice.targets.push_back(twice.targets[0]);
  EXPECT_THAT(refusal(twice), HasSubstr("key 'targets.seed'"));
  EXPECT_THAT(message_of(changed(needle_scene, "top:", "left:")),
              HasSubstr("second one of this key"));
  const std::string curves = "{name: a, points: [[0 m, 1 cm], [1 cm, 1 cm]]}";
  EXPECT_THAT(message_of(block_scene, {"mesh.rectangle.curves=[" + curves + ", " + curves + "]"}),
              HasSubstr("key 'mesh.rectangle.curves.1.name'"));
}

TEST(Check, MeshKeysFitTogether) {
  EXPECT_THAT(message_of(block_scene, {"mesh.scale=2"}),
              HasSubstr("key 'mesh.scale': value '2'; allowed: only with mesh.file"));
  EXPECT_THAT(
      message_of(block_scene, {"mesh.rectangle.inner_regions=[{name: a, polygon: [[0 m, 0 m]]}]"}),
      HasSubstr("at least 3 points"));
  EXPECT_THAT(message_of(block_scene, {"mesh.rectangle.curves=[{name: a, points: [[0 m, 0 m]]}]"}),
              HasSubstr("at least 2 points"));
  EXPECT_THAT(message_of(block_scene,
                         {"mesh.rectangle.curves=[{name: top, points: [[0 m, 0 m], [1 m, 0 m]]}]"}),
              HasSubstr("not a side"));
  EXPECT_THAT(message_of(needle_scene, {"membrane={polygon: [[0 m, 0 m]], puncture_force: 1 N}"}),
              HasSubstr("key 'membrane.polygon'"));
}

TEST(Check, LoadsAndExpectationsSaySomething) {
  EXPECT_THAT(message_of(block_scene, {"prescribed=[{curve: a, displacement: [null, null]}]"}),
              HasSubstr("at least one component"));
  EXPECT_THAT(message_of(block_scene, {"expect=[{quantity: time}]"}), HasSubstr("a min or a max"));
  EXPECT_THAT(message_of(block_scene, {"expect=[{quantity: time, min: 2, max: 1}]"}),
              HasSubstr("key 'expect.0.max': value '1'; allowed: >= min, which is 2"));
  EXPECT_THAT(message_of(block_scene, {"tissue.regions={}"}), HasSubstr("at least one region"));
}

TEST(Check, ExpectationsAreOfNumbersThatARunHasInTheirUnit) {
  const auto expect = [](const std::string& quantity, const std::string& max) {
    return message_of(needle_scene, {"expect=[{quantity: " + quantity + ", max: " + max + "}]"});
  };
  EXPECT_EQ(expect("seeds.0.placement_error", "5 mm"), "no error");
  EXPECT_EQ(expect("seeds.0.placement_error", "0.005"), "no error");
  EXPECT_EQ(expect("peak_needle_force", "5 N"), "no error");
  EXPECT_THAT(expect("seeds.0.placement_error", "5 N"),
              HasSubstr("key 'expect.0.max': value '5 N' is not convertible to m"));
  EXPECT_THAT(expect("peak_needle_force", "5 mm"), HasSubstr("not convertible to N"));
  EXPECT_THAT(expect("punctures", "2 m"), HasSubstr("key 'expect.0.max': value '2 m'"));
  EXPECT_THAT(
      expect("seeds.1.placement_error", "5 mm"),
      HasSubstr("key 'expect.0.quantity': value 'seeds.1.placement_error'; allowed: a number "
                "that a run of this scene has, such as 'seeds.0.placement_error'; all: time"));
  EXPECT_THAT(expect("placement_eror", "5 mm"), HasSubstr("expect.0.quantity"));
  EXPECT_THAT(expect("stable_step", "1 s"), HasSubstr("expect.0.quantity"));
  // Names with dots stand in quotes, as everywhere.
  const auto of_probe = [](const std::string& quantity) {
    return message_of(needle_scene, {"probes={a.b: [4 cm, 3 cm]}",
                                     "expect=[{quantity: '" + quantity + "', max: 1 mm}]"});
  };
  EXPECT_EQ(of_probe(R"(probes."a.b".0)"), "no error");
  EXPECT_THAT(of_probe("probes.a.b.0"), HasSubstr(R"(such as 'probes."a.b".0')"));
  const Scene scene = load_scene("s.yaml", needle_scene,
                                 {"expect=[{quantity: seeds.0.world.1, min: -1 cm, max: 2}]"});
  EXPECT_EQ(scene.expect[0].min, -0.01);
  EXPECT_EQ(scene.expect[0].max, 2);
  EXPECT_NO_THROW(check(scene));
}

TEST(Check, ACurveIsHeldMovedOrLoadedOnce) {
  const std::string once = "{curve: right, displacement: [1 mm, 0 mm]}";
  EXPECT_EQ(message_of(needle_scene, {"prescribed=[" + once + "]"}), "no error");
  EXPECT_THAT(message_of(needle_scene, {"prescribed=[" + once + ", " + once + "]"}),
              HasSubstr("key 'prescribed.1.curve': value 'right'; allowed: one entry a curve"));
  EXPECT_THAT(message_of(needle_scene, {"prescribed=[" + once + "]", "supports.right=fixed"}),
              HasSubstr("supports.right is fixed"));
  EXPECT_EQ(message_of(needle_scene, {"prescribed=[" + once + "]", "supports.right=free"}),
            "no error");
  const std::string load = "{curve: right, force: [1 N/m, 0 N/m]}";
  EXPECT_THAT(message_of(needle_scene, {"loads.traction=[" + load + ", " + load + "]"}),
              HasSubstr("key 'loads.traction.1.curve'"));
  EXPECT_THAT(message_of(block_scene,
                         {"time.duration=1 s",
                          "prescribed=[{curve: right, displacement: [1 mm, 0 mm], start: 2 s}]"}),
              HasSubstr("key 'prescribed.0.start': value '2 s'; allowed: at most time.duration"));
}

TEST(Check, AProcedureTakesThePlaceOfNeedles) {
  EXPECT_EQ(message_of(block_scene, {"procedure.file=rows.yaml"}), "no error");
  EXPECT_THAT(message_of(needle_scene, {"procedure.file=rows.yaml"}),
              HasSubstr("key 'needles': value"));
  EXPECT_THAT(message_of(block_scene, {"procedure.file=rows.yaml", "time.duration=1 s"}),
              HasSubstr("key 'time.duration'"));
  EXPECT_THAT(message_of(block_scene, {"procedure.file=rows.yaml", "time.until=implanted"}),
              HasSubstr("key 'time.until'"));
}

TEST(Check, APictureOfAFileHasAPlace) {
  EXPECT_EQ(message_of(block_scene, {"image={seed: 1}"}), "no error");
  EXPECT_THAT(message_of(block_scene, {"image={file: a.png, size: [1 cm, 1 cm]}"}),
              HasSubstr("key 'image.origin': missing; allowed: where the picture"));
  EXPECT_THAT(message_of(block_scene, {"image={size: [1 cm, 1 cm]}"}),
              HasSubstr("key 'image.size': value"));
}

TEST(Check, ANeedleOfAHandIsCheckedLikeThatOfAScene) {
  const Scene scene = load_scene("s.yaml", needle_scene);
  NeedleParameters needle = scene.needles[0];
  needle.name = "mine";
  needle.motion.clear();
  EXPECT_NO_THROW(check_needle(scene, needle));
  needle.friction->slip_speed = 0.1e-3;
  try {
    check_needle(scene, needle);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("key 'needles.0.friction.slip_speed'"));
  }
  needle = scene.needles[0];
  needle.cutting.tip_length = -1;
  EXPECT_THROW(check_needle(scene, needle), InputError);
}

TEST(Check, ScenesMadeInCodeKeepTheRangesToo) {
  Scene scene = load_scene("s.yaml", needle_scene);
  scene.needles[0].cutting.sharpness = 2;
  EXPECT_THROW(check(scene), InputError);
  scene = load_scene("s.yaml", needle_scene);
  scene.needles[0].motion[0].position = 0.01;
  EXPECT_THROW(check(scene), InputError);
  scene = load_scene("s.yaml", needle_scene);
  scene.time.step = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(check(scene), InputError);
}

}  // namespace
}  // namespace stylet
