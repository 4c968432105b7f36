#include "cases.hpp"

namespace stylet {

const char* needle_scene() {
  return R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 20, rows: 15}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.49, density: 1000 kg/m^3}}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed, top: fixed, bottom: fixed}
targets: {seed: [5 cm, 3.1 cm]}
needles:
  - height: 3.1 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion:
      - insert: {speed: 2 cm/s, depth: 3 cm}
      - implant: {target: seed}
      - retract: {speed: 2 cm/s, depth: 1 cm}
time: {method: implicit, scheme: backward_euler, step: 20 ms}
)";
}

namespace {

const std::string modulus = "tissue.regions.tissue.youngs_modulus=";
const std::string ratio = "tissue.regions.tissue.poisson_ratio=";
const std::string density = "tissue.regions.tissue.density=";
const std::string needle = "needles.0.";

std::string insert(const std::string& speed, const std::string& depth) {
  return needle + "motion=[{insert: {speed: " + speed + ", depth: " + depth +
         "}}, {implant: {target: seed}}]";
}

std::string reversals(int n) {
  std::string motion = needle + "motion=[{insert: {speed: 5 cm/s, depth: 15 mm}}";
  for (int i = 0; i < n; ++i) {
    motion += ", {retract: {speed: 5 cm/s, depth: 14 mm}}, {insert: {speed: 5 cm/s, depth: 15 mm}}";
  }
  return motion + ", {implant: {target: seed}}]";
}

}  // namespace

std::vector<Extreme> needle_extremes() {
  std::vector<Extreme> all;
  const auto add = [&](std::string name, std::vector<std::string> overrides,
                       Wanted wanted = Wanted::answer, bool is_long = false) {
    all.push_back({std::move(name), std::move(overrides), wanted, is_long});
  };
  for (const std::string e : {"1 Pa", "1 kPa", "1 MPa", "1 GPa"}) {
    add("E " + e, {modulus + e}, Wanted::either);
    add("E " + e + ", all forces in proportion", {modulus + e, "scale=" + e});
  }
  for (const std::string nu : {"0", "0.3", "0.499", "0.49999"}) {
    for (const std::string plane : {"stress", "strain"}) {
      add("nu " + nu + ", plane " + plane, {ratio + nu, "tissue.plane=" + plane});
    }
  }
  for (const std::string rho : {"1 kg/m^3", "1e5 kg/m^3"}) add("density " + rho, {density + rho});
  for (const std::string scheme : {"backward_euler", "average_acceleration", "generalised_alpha"}) {
    const std::string use = "time.scheme=" + scheme;
    add("h 1e-7 s, " + scheme, {use, "time.step=1e-7 s", insert("10 m/s", "0.05 mm")},
        Wanted::either);
    add("h 1e-4 s, " + scheme, {use, "time.step=1e-4 s", insert("1 m/s", "20 mm")});
    add("h 0.2 s, " + scheme, {use, "time.step=0.2 s"});
    add("h 10 s, a needle of 1e-5 m/s, " + scheme,
        {use, "time.step=10 s", insert("1e-5 m/s", "10 mm")});
    add("density 1e5, h 1 ms, no damping, " + scheme,
        {use, density + "1e5 kg/m^3", "time.step=1 ms", "tissue.damping=null",
         insert("5 cm/s", "2 cm")},
        // Undamped waves of heavy tissue come back to the tip; the trapezoid rule keeps them all.
        scheme == "backward_euler" ? Wanted::answer : Wanted::either);
  }
  add("h 10 s, a needle of 2 cm/s", {"time.step=10 s"}, Wanted::refusal);
  add("speed 10 m/s", {"time.step=20 us", insert("10 m/s", "3 cm")}, Wanted::either);
  add("speed 1e-5 m/s, quasi-static",
      {"time.method=quasi_static", "time.step=20 s", insert("1e-5 m/s", "20 mm")});
  add("quasi-static", {"time.method=quasi_static"});
  add("explicit", {"time.method=explicit", "tissue.damping={mass_factor: 200 1/s}",
                   "needles.0.cutting.law=lagged", insert("20 cm/s", "2 cm")});
  add("explicit, E 1 GPa",
      {"time.method=explicit", modulus + "1 GPa", "time.step=0.1 ms",
       "tissue.damping={mass_factor: 200 1/s}", "needles.0.cutting.law=lagged",
       insert("5 m/s", "5 mm")},
      Wanted::either);
  for (const std::string force : {"1e-6 N", "1 mN", "100 N", "1e6 N"}) {
    add("cutting force " + force, {needle + "cutting.cutting_force=" + force}, Wanted::either);
  }
  add("cutting force 0", {needle + "cutting.cutting_force=0 N"}, Wanted::refusal);
  add("no friction", {needle + "friction=null"});
  for (const std::string friction : {"1e-6", "1e4", "1e6"}) {
    add("friction " + friction + " N/m",
        {needle + "friction.static_force=" + friction + " N/m",
         needle + "friction.kinetic_force=" + friction + " N/m"},
        Wanted::either);
  }
  const std::string core =
      "mesh.rectangle.inner_regions=[{name: core, ellipse: {centre: [4 cm, 3 cm], size: [3.5 cm, "
      "2.6 cm]}}]";
  const auto core_of = [](const std::string& e) {
    return "tissue.regions.core={youngs_modulus: " + e +
           ", poisson_ratio: 0.49, density: 1000 kg/m^3}";
  };
  add("membrane force 1e9 N",
      {core, core_of("60 kPa"), "membrane={region: core, puncture_force: 1e9 N}"}, Wanted::either);
  add("core 1e6 times stiffer", {core, core_of("60 GPa")}, Wanted::either);
  add("core 1e6 times softer", {core, core_of("0.06 Pa")}, Wanted::either);
  add("grazing the core", {core, core_of("600 kPa"), needle + "height=4.299 cm"}, Wanted::either);
  add("along an edge of the mesh, through nodes", {needle + "height=3.2 cm"});
  add("a nanometre beside it", {needle + "height=3.2000001 cm"});
  add("at a corner of the tissue", {needle + "height=5.9999 cm"}, Wanted::either);
  add("at the corner itself", {needle + "height=6 cm"}, Wanted::refusal);
  add("beside the tissue", {needle + "height=7 cm"}, Wanted::refusal);
  add("ten reversals", {reversals(10)});
  add("a thousand reversals", {reversals(1000), "time.step=10 ms"}, Wanted::answer, true);
  add("out of the far side", {insert("2 cm/s", "9 cm")}, Wanted::refusal);
  add("to the far side", {insert("2 cm/s", "8 cm")}, Wanted::refusal);
  add("less than an element before the far side", {insert("2 cm/s", "7.8 cm")}, Wanted::either);
  add("far side free, less than an element before it",
      {insert("2 cm/s", "7.8 cm"), "supports={top: fixed, bottom: fixed}"}, Wanted::either);
  add("target where the needle ends", {"targets.seed=[5 cm, 3.1 cm]"});
  add("target at a node", {"targets.seed=[4.8 cm, 3.2 cm]"});
  return all;
}

const char* bar_scene() {
  return R"(
mesh: {rectangle: {size: [10 cm, 1 cm], columns: 10, rows: 4}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}}
supports: {left: roller, bottom: roller}
loads: {traction: [{curve: right, force: [1 N/m, 0 N/m]}]}
probes: {end: [10 cm, 0 cm]}
time: {method: quasi_static, step: 1 s}
)";
}

std::vector<Extreme> bar_extremes() {
  std::vector<Extreme> all;
  for (const std::string e : {"1 Pa", "60 kPa", "1 GPa"}) {
    for (const std::string nu : {"0", "0.3", "0.49999"}) {
      all.push_back({"bar, E " + e + ", nu " + nu, {modulus + e, ratio + nu}});
    }
  }
  // Square cells of 1 cm become flat by the bar's height.
  for (const std::string height : {"1 mm", "0.1 mm", "1 um"}) {
    all.push_back({"bar " + height + " high, element aspect 1 cm to it over 4",
                   {"mesh.rectangle.size=[10 cm, " + height + "]"},
                   Wanted::either});
  }
  return all;
}

}  // namespace stylet
