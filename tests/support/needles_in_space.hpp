// A scene of two needles in a box with a gland, in some seventy steps of 5 ms.
#pragma once

namespace stylet {

inline const char* const needles_in_space = R"(
mesh:
  box:
    size: [6 cm, 4 cm, 4 cm]
    columns: 7
    rows: 5
    layers: 5
    inner_regions:
      - {name: gland, ellipsoid: {centre: [3 cm, 2 cm, 2 cm], size: [2.8 cm, 2.8 cm, 2.8 cm]}}
tissue:
  regions:
    tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
    gland: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
supports: {left: fixed}
membrane: {region: gland, puncture_force: 2 N}
targets: {seed: [4 cm, 2 cm, 2 cm]}
needles:
  - entry: [6 cm, 2.1 cm, 1.9 cm]
    direction: [-1, 0, 0]
    kernel_radius: 8 mm
    segment: 1 mm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion:
      - insert: {speed: 20 cm/s, depth: 28 mm}
      - implant
      - retract: {speed: 30 cm/s, depth: 15 mm}
      - insert: {speed: 20 cm/s, depth: 20 mm}
      - retract: {speed: 30 cm/s}
      - settle: {duration: 30 ms}
  - entry: [7 cm, 2.1 cm, 1.9 cm]
    target: [4 cm, 1.9 cm, 2.2 cm]
    kernel_radius: 8 mm
    segment: 1 mm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s, viscous_coefficient: 200 N s/m^2}
    motion:
      - insert: {speed: 20 cm/s, depth: 2 cm}
      - retract: {speed: 30 cm/s}
)";

}  // namespace stylet
