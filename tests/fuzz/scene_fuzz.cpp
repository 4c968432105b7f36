// A scene, then overrides, parted by null characters; without a scene, overrides of a small one.
#include "stylet/scene/loader.hpp"
#include "stylet/scene/writer.hpp"

#include "fuzz.hpp"

#include <vector>

namespace {

const char* const small = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 4, rows: 3}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.49, density: 1000 kg/m^3}}
supports: {left: fixed}
needles:
  - height: 3 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    motion: [{insert: {speed: 2 cm/s, depth: 4 cm}}, implant, {retract: {speed: 2 cm/s}}, settle]
targets: {seed: [4 cm, 3 cm]}
)";

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stylet;
  std::vector<std::string> parts(1);
  for (const char c : fuzz::text_of(data, size)) {
    if (c == '\0') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  const std::string scene = parts[0].empty() ? small : parts[0];
  parts.erase(parts.begin());
  fuzz::may_refuse([&] {
    const std::string written = to_yaml(load_scene("s", scene, parts));
    std::string again;
    try {
      again = to_yaml(load_scene("s", written));
    } catch (const InputError& error) {
      std::fprintf(stderr, "%s\n%s", error.what(), written.c_str());
    }
    fuzz::require(written == again, "what is written of a scene reads back as the same");
  });
  return 0;
}
