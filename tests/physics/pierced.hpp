// Two small scenes: a block that a needle pierces, beside an inner curve 'wall', and one that is
// stretched.
#pragma once

#include <string>

namespace stylet {

inline const std::string pierced = R"(
mesh:
  rectangle:
    size: [6 cm, 4 cm]
    columns: 12
    rows: 8
    curves: [{name: wall, points: [[3 cm, 1 cm], [3 cm, 3 cm]]}]
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 30 kPa, poisson_ratio: 0.4, density: 1000 kg/m^3}}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 2.2 cm
    cutting: {cutting_force: 0.6 N, tip_length: 5 mm}
    motion: [insert: {speed: 4 cm/s, depth: 2.5 cm}, implant: {}, retract: {speed: 4 cm/s}, settle: {}]
targets: {seed: [3.4 cm, 2.2 cm]}
time: {step: 25 ms}
)";

inline const std::string stretched = R"(
mesh: {rectangle: {size: [4 cm, 2 cm], columns: 4, rows: 2}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 20 kPa, poisson_ratio: 0.25, density: 1000 kg/m^3}}
supports: {left: roller, bottom: roller}
prescribed: [{curve: right, displacement: [4 mm, null]}]
time: {method: quasi_static}
)";

inline std::string motion(const std::string& actions) {
  return "needles.0.motion=[" + actions + "]";
}

}  // namespace stylet
