// Keys that are another way to write a key: the same value to the last digit, or a refusal.
#include "stylet/scene/gauge.hpp"
#include "stylet/scene/procedure.hpp"
#include "stylet/scene/writer.hpp"

#include "example.hpp"
#include <gmock/gmock.h>

#include <numbers>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string space_scene =
    R"(mesh: {box: {size: [8 cm, 6 cm, 5 cm], columns: 8, rows: 6, layers: 5}}
tissue: {regions: {tissue: {youngs_modulus: 30 kPa, poisson_ratio: 0.49, density: 1e3 kg/m^3}}}
needles:
  - entry: [8 cm, 3 cm, 2 cm]
    direction: [-1, 0.1, 0]
    diameter: 1.27 mm
    kernel_radius: 11 mm
    cutting: {cutting_force: 1 N, tip_length: 5 mm}
    friction: {static_force: 3 N/m, kinetic_force: 2 N/m, stick_speed: 1 mm/s, slip_speed: 2 mm/s}
    motion: [insert: {speed: 1 cm/s, depth: 3 cm}]
)";

std::string with(const std::string& from, const std::string& to) {
  return changed(space_scene, from, to);
}

TEST(Spelling, AGaugeIsItsDiameter) {
  EXPECT_EQ(to_yaml(load_scene("s.yaml", with("diameter: 1.27 mm", "gauge: 18"))),
            to_yaml(load_scene("s.yaml", space_scene)));
  for (const auto& [gauge, diameter] : needle_gauges) {
    const auto given = [&](const std::string& key) {
      return load_scene("s.yaml", needle_scene, {"needles.0." + key}).needles[0].diameter;
    };
    EXPECT_EQ(given("gauge=" + std::to_string(gauge)),
              given("diameter=" + std::to_string(diameter) + " mm"));
  }
}

// Designated metric sizes of ISO 9626 (mm), which are rounded: within 7 %.
TEST(Spelling, GaugesFallAndFitTheMetricSizes) {
  constexpr std::array metric = {3.4,  3.0,  2.7, 2.4,  2.1,  1.8,  1.6, 1.4,  1.2,
                                 1.1,  0.9,  0.8, 0.7,  0.6,  0.55, 0.5, 0.45, 0.4,
                                 0.36, 0.33, 0.3, 0.25, 0.23, 0.2,  0.18};
  for (std::size_t i = 0; i < needle_gauges.size(); ++i) {
    EXPECT_EQ(needle_gauges[i].gauge, 10 + static_cast<int>(i));
    EXPECT_NEAR(needle_gauges[i].diameter / metric.at(i), 1, 0.07) << needle_gauges[i].gauge;
    EXPECT_LT(needle_gauges[i].diameter, i > 0 ? needle_gauges[i - 1].diameter : 3.5);
  }
}

TEST(Spelling, OtherGaugesAndBothAreRefused) {
  EXPECT_THAT(message_of(with("diameter: 1.27 mm", "gauge: 9")),
              AllOf(HasSubstr("scene.yaml:6:12: key 'needles.0.gauge': value '9'"),
                    HasSubstr("allowed: 10, 11, 12, "), HasSubstr("33, 34")));
  EXPECT_THAT(message_of(with("diameter: 1.27 mm", "gauge: 18.0")), HasSubstr("needles.0.gauge"));
  EXPECT_THAT(message_of(space_scene, {"needles.0.gauge=18"}),
              AllOf(HasSubstr("needles.0.gauge"), HasSubstr("one of diameter and gauge")));
}

TEST(Spelling, AStressOnTheShaftIsAForcePerMetre) {
  const double circumference = std::numbers::pi * 1.27e-3;
  const Scene scene =
      load_scene("s.yaml", with("static_force: 3 N/m, kinetic_force: 2 N/m",
                                "viscous_stress_coefficient: 50 kPa s/m, static_stress: 700 Pa, "
                                "kinetic_stress: 0.5 kPa"));
  const FrictionParameters& friction = scene.needles[0].friction.value();
  EXPECT_DOUBLE_EQ(friction.static_force, 700 * circumference);
  EXPECT_DOUBLE_EQ(friction.kinetic_force, 500 * circumference);
  EXPECT_DOUBLE_EQ(friction.viscous_coefficient, 5e4 * circumference);
  EXPECT_EQ(to_yaml(load_scene("s.yaml", to_yaml(scene))), to_yaml(scene));
  // Of the diameter that the needle has, wherever it stands.
  const Scene wide = load_scene("s.yaml", with("static_force: 3 N/m", "static_stress: 1 kPa"),
                                {"needles.0.diameter=null", "needles.0.gauge=14"});
  EXPECT_DOUBLE_EQ(wide.needles[0].friction->static_force, std::numbers::pi * 2.108);
}

TEST(Spelling, StressesAreRefusedInThePlaneAndBesideForces) {
  const std::string why = "static_force: only a needle in space, with entry, has a surface";
  EXPECT_THAT(message_of(changed(needle_scene, "static_force: 195 N/m", "static_stress: 1 kPa")),
              AllOf(HasSubstr("key 'needles.0.friction.static_stress'"), HasSubstr(why)));
  std::string note;
  const std::string row =
      "- {enter: {name: a, height: 3 cm, cutting: {cutting_force: 1 N}, friction: "
      "{static_stress: 1 kPa, kinetic_force: 1 N/m, stick_speed: 1 mm/s, slip_speed: 2 mm/s}}}\n";
  EXPECT_THROW((void)read_procedure("p.yaml", row, note), InputError);
  for (const std::string name : {"static_stress=1 kPa", "kinetic_stress=1 Pa"}) {
    EXPECT_THAT(message_of(space_scene, {"needles.0.friction." + name}),
                HasSubstr("_stress': value"));
  }
  EXPECT_THAT(message_of(with("static_force: 3 N/m", "static_stress: 1e308 Pa"),
                         {"needles.0.diameter=null", "needles.0.diameter=10 m"}),
              HasSubstr("key 'needles.0.friction.static_stress'"));
  EXPECT_THAT(message_of(space_scene, {"needles.0.friction.viscous_coefficient=1 N s/m^2",
                                       "needles.0.friction.viscous_stress_coefficient=1 Pa s/m"}),
              HasSubstr("one of viscous_coefficient and viscous_stress_coefficient"));
  EXPECT_THAT(message_of(with("static_force: 3 N/m, ", "")),
              AllOf(HasSubstr("friction.static_force': missing"), HasSubstr(", or static_stress")));
}

TEST(Spelling, ACrackIsACuttingForce) {
  const std::string crack = "fracture: {toughness: 2 kJ/m^2, width: 0.5 mm}";
  for (const std::string& scene : {space_scene, changed(needle_scene, "1.7 N", "1 N")}) {
    EXPECT_EQ(to_yaml(load_scene("s.yaml", changed(scene, "cutting_force: 1 N", crack))),
              to_yaml(load_scene("s.yaml", scene)));
  }
  EXPECT_THAT(message_of(space_scene, {"needles.0.cutting." +
                                       std::string("fracture={toughness: 1 J/m^2, width: 1 mm}")}),
              HasSubstr("one of cutting_force and fracture"));
  EXPECT_THAT(message_of(with("cutting_force: 1 N", "fracture: {toughness: 1 J/m^2}")),
              HasSubstr("key 'needles.0.cutting.fracture.width': missing"));
  // None that overflows or vanishes.
  for (const std::string numbers :
       {"toughness: 1e300 J/m^2, width: 1e300 m", "toughness: 1e-300 J/m^2, width: 1e-300 m"}) {
    EXPECT_THAT(message_of(with("cutting_force: 1 N", "fracture: {" + numbers + "}")),
                AllOf(HasSubstr("key 'needles.0.cutting.fracture'"), HasSubstr("above 0 N")));
  }
}

}  // namespace
}  // namespace stylet
