// Scenes that the tests change in one place, and the message that follows.
#pragma once

#include "stylet/base/errors.hpp"
#include "stylet/scene/loader.hpp"

#include <string>
#include <vector>

namespace stylet {

/// Valid; line numbers matter to the tests.
inline const std::string needle_scene = R"(mesh: {file: block.msh}
tissue:
  plane: stress
  regions:
    prostate: {youngs_modulus: 60 kPa, poisson_ratio: 0.49, density: 1000 kg/m^3}
    surrounding: {youngs_modulus: 40 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
supports: {left: fixed, top: roller}
needles:
  - height: 3.2 cm
    cutting: {cutting_force: 1.7 N}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion:
      - insert: {speed: 2 cm/s, depth: 4 cm}
      - implant
      - retract: {speed: 2 cm/s}
      - settle: {duration: 1 s}
targets: {seed: [3.5 cm, 3.2 cm]}
)";

/// Valid; a rectangle without a needle.
inline const std::string block_scene =
    R"(mesh: {rectangle: {size: [8 cm, 6 cm], columns: 8, rows: 6}}
tissue:
  plane: strain
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 0 kg/m^3}}
time: {method: quasi_static}
)";

/// The message that loading ends with, or 'no error'.
inline std::string message_of(const std::string& text,
                              const std::vector<std::string>& overrides = {}) {
  try {
    static_cast<void>(load_scene("scene.yaml", text, overrides));
    return "no error";
  } catch (const InputError& error) {
    return error.what();
  }
}

/// needle_scene or block_scene with one piece of text replaced.
inline std::string changed(std::string scene, const std::string& from, const std::string& to) {
  const auto at = scene.find(from);
  if (at == std::string::npos) throw std::logic_error("the example does not contain " + from);
  return scene.replace(at, from.size(), to);
}

}  // namespace stylet
