#include "stylet/scene/writer.hpp"

#include "stylet/scene/schema.hpp"

#include "example.hpp"
#include <gmock/gmock.h>

#include <fstream>
#include <set>
#include <sstream>

namespace stylet {
namespace {

/// Between them they give every key of the schema but other spellings of keys.
const std::string everything = R"(mesh:
  rectangle:
    origin: [-1 cm, 1e-3 m]
    size: [8 cm, 6 cm]
    columns: 10
    rows: 7
    diagonals: one_way
    jitter: 0.1
    seed: 42
    region: fat
    inner_regions:
      - {name: "a: b", ellipse: {centre: [3.5 cm, 3 cm], size: [3.5 cm, 2.6 cm]}}
      - {name: "null", polygon: [[0 m, 0 m], [1 cm, 0 m], [0.3333333333333333 cm, 1 cm]]}
    curves: [{name: slit, points: [[1 cm, 1 cm], [2 cm, 1 cm]]}]
  refine: 2
tissue:
  plane: strain
  thickness: 2 cm
  formulation: p1
  mass: lumped
  regions:
    zebra: {youngs_modulus: 61.7 kPa, poisson_ratio: 0.4999, density: 1e3 kg/m^3}
    "a.b c": {youngs_modulus: 1 Pa, poisson_ratio: 0, density: 900 kg/m^3}
  damping: {mass_factor: 3 1/s, stiffness_factor: 5 ms}
supports: {top: roller, left: fixed, bottom: free}
loads:
  body: [{force: [0 N/m^3, -9.81 kN/m^3], start: 1 ms}]
  traction: [{curve: right, force: [1 N/m, 0.1 N/m], start: 2 s}]
prescribed: [{curve: slit, displacement: [null, 1 mm], start: 1 s, ramp: 2 s}]
needles:
  - name: first
    height: 3.3 cm
    cutting: {law: increment, cutting_force: 1.7 N, sharpness: 0.7, stiffness_share: 0.3,
              reference_youngs_modulus: 60 kPa, tip_length: 6 mm, increment: 0.1 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s,
               viscous_coefficient: 2.5 kN s/m^2}
    motion:
      - insert: {speed: 2 cm/s, depth: 4 cm}
      - implant: {target: b}
      - hold: {duration: 0.1 s}
      - retract: {speed: 2 cm/s, position: 5 cm}
      - retract: {speed: 2 cm/s, depth: 1 cm}
      - retract: {speed: 3 cm/s}
      - settle: {speed_tolerance: 1 um/s}
  - height: 1 cm
    cutting: {cutting_force: 1 N, law: lagged}
    motion: [insert: {speed: 1 cm/s, position: 3 cm}, implant: {target: a}, settle: {duration: 7 s}]
membrane: {region: zebra, puncture_force: 2.55 N}
targets: {b: [1 cm, 1.1 cm], a: [0.1 m, 1 um]}
probes: {p: [3 mm, 1 mm], o: [1 mm, 2 mm]}
time: {method: explicit, scheme: generalised_alpha, rho_infinity: 0.25, step: 0.7 ms, until: settled, safety: 0.8}
output: {directory: out/a b, history: false, snapshots: 50 ms, checkpoint: {steps: 10, wall_time: 60 s, keep: 3, at_end: true}}
expect: [{quantity: seeds.0.placement_error, min: 5.5 mm, max: 7.5 mm}, {quantity: steps, max: 1e6}]
)";

const std::string in_space = R"(mesh:
  box:
    origin: [-1 cm, 0 m, 2 m]
    size: [8 cm, 6 cm, 5 cm]
    columns: 10
    rows: 7
    layers: 6
    jitter: 0.1
    seed: 3
    region: fat
    inner_regions: [{name: gland, ellipsoid: {centre: [3 cm, 3 cm, 2.02 m], size: [2 cm, 3 cm, 1 cm]}}]
tissue:
  regions:
    fat: {youngs_modulus: 30 kPa, poisson_ratio: 0.49, density: 1e3 kg/m^3}
    gland: {youngs_modulus: 60 kPa, poisson_ratio: 0.4, density: 1e3 kg/m^3}
supports: {left: fixed, front: roller}
loads:
  body: [{force: [0 N/m^3, -9.81 kN/m^3, 0 N/m^3]}]
  traction: [{surface: right, stress: [1 Pa, 0 Pa, 0.1 kPa], start: 1 s}]
prescribed: [{surface: top, displacement: [null, 1 mm, 0 m], ramp: 2 s}]
probes: {p: [1 cm, 2 cm, 2.01 m]}
time: {duration: 3 s}
)";

const std::string needles_in_space =
    R"(mesh: {box: {size: [8 cm, 6 cm, 5 cm], columns: 8, rows: 6, layers: 5}}
tissue:
  regions: {tissue: {youngs_modulus: 30 kPa, poisson_ratio: 0.49, density: 1e3 kg/m^3}}
needles:
  - entry: [8 cm, 3 cm, 2 cm]
    direction: [-1, 0.1, 0]
    diameter: 2 mm
    kernel_radius: 11 mm
    segment: 0.7 mm
    cutting: {cutting_force: 1 N, tip_length: 5 mm}
    motion: [insert: {speed: 1 cm/s, depth: 3 cm}, retract: {speed: 1 cm/s}]
  - entry: [8 cm, 3 cm, 3 cm]
    target: [4 cm, 3.1 cm, 2 cm]
    kernel_radius: 11 mm
    cutting: {cutting_force: 1 N, tip_length: 5 mm}
    motion: [insert: {speed: 1 cm/s, depth: 3 cm}]
membrane: {surface: front, puncture_force: 2 N}
targets: {t: [4 cm, 3 cm, 2 cm]}
time: {method: quasi_static}
)";

std::string polygon_scene() {
  return changed(needle_scene, "block.msh}", "a b/block.msh, scale: 0.001}") +
         "membrane: {polygon: [[0 m, 0 m], [1 cm, 0 m], [0 m, 1 cm]], puncture_force: 1 N}\n";
}

const std::string procedure_scene =
    R"(mesh: {rectangle: {size: [8 cm, 6 cm], columns: 8, rows: 6}}
tissue:
  plane: strain
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1 g/cm^3}}
procedure: {file: "a b/procedure.yaml"}
start: {from: checkpoints/00000010.h5}
image: {file: a.png, origin: [1 cm, -2 mm], size: [3 cm, 0.1 m], seed: 3, attenuation: 7.25 1/m,
        shadow: 0.3}
expect: [{quantity: seeds.3.placement_error, max: 1 mm}]
)";

void collect(const Node& node,
             const Key& key,
             const std::string& path,
             std::set<std::string>& out) {
  for (const Node& child : node.children) {
    const bool is_list = key.form == Key::Form::list;
    for (const Key& below : key.keys) {
      const bool any_name = is_list || key.form == Key::Form::named;
      if (!any_name && below.name != child.key) continue;
      const std::string name =
          is_list ? path + "[]" : path + (path.empty() ? "" : ".") + below.name;
      out.insert(name);
      collect(child, below, name, out);
    }
  }
}

TEST(Writer, WritesEveryKeyOfTheSchemaInOneSpelling) {
  std::set<std::string> written;
  for (const std::string& text :
       {everything, polygon_scene(), block_scene, procedure_scene, in_space, needles_in_space}) {
    collect(to_document(load_scene("s.yaml", text)), scene_codec().key, {}, written);
  }
  std::string spelling = "none";
  for (const SchemaRow& row : schema_rows()) {
    if (!row.key->spells.empty()) spelling = row.path;
    const bool is_spelling = row.path == spelling || row.path.starts_with(spelling + ".");
    EXPECT_EQ(written.contains(row.path), !is_spelling) << row.path;
  }
}

TEST(Writer, WhatItWritesLoadsToTheSameScene) {
  for (const std::string& text : {everything, polygon_scene(), needle_scene, block_scene,
                                  procedure_scene, in_space, needles_in_space}) {
    const std::string once = to_yaml(load_scene("s.yaml", text));
    const std::string twice = to_yaml(load_scene("s.yaml", once));
    EXPECT_EQ(once, twice);
  }
}

TEST(Writer, ValuesSurviveBitByBit) {
  const Scene a = load_scene("s.yaml", everything);
  const Scene b = load_scene("s.yaml", to_yaml(a));
  const auto& from = std::get<RectangleMesh>(a.mesh.source);
  const auto& to = std::get<RectangleMesh>(b.mesh.source);
  EXPECT_EQ(to.origin, from.origin);
  EXPECT_EQ(to.inner_regions[0].name, "a: b");
  EXPECT_EQ(to.inner_regions[1].name, "null");
  EXPECT_EQ(std::get<1>(to.inner_regions[1].outline), std::get<1>(from.inner_regions[1].outline));
  EXPECT_EQ(b.tissue.regions[1].region, "a.b c");
  EXPECT_EQ(b.tissue.regions[0].material.youngs_modulus, 61700.0);
  EXPECT_EQ(b.needles[0].motion[6].speed_tolerance, a.needles[0].motion[6].speed_tolerance);
  EXPECT_EQ(b.needles[1].name, "needle2");
  EXPECT_EQ(b.supports[0].curve, "top");
  EXPECT_EQ(b.targets[1].point, a.targets[1].point);
  EXPECT_EQ(b.body_forces[0].force, (Vector2{0, -9810}));
  EXPECT_EQ(b.expect[1].max, 1e6);
  EXPECT_EQ(b.expect[1].min, Expectation{}.min);
}

TEST(Writer, TheScenesOfTheInputFolderLoad) {
  for (const std::string name : {"prostate.yaml", "block.yaml", "box.yaml"}) {
    const std::string path = std::string(STYLET_SOURCE_DIR) + "/input/" + name;
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    const Scene scene = load_scene(path, text.str());
    EXPECT_EQ(to_yaml(load_scene(path, to_yaml(scene))), to_yaml(scene));
  }
}

}  // namespace
}  // namespace stylet
