#include "stylet/base/text.hpp"
#include "stylet/base/units.hpp"

#include "fuzz.hpp"

#include <cmath>

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stylet;
  const std::string text = fuzz::text_of(data, size);
  for (const char* unit : {"m", "N", "s", "Pa", "m/s", "rad", "kg/m^3", "1/s"}) {
    const Reading reading = read_quantity(text, unit);
    if (!reading.fault.empty()) continue;
    fuzz::require(std::isfinite(reading.value), "values are finite");
    const Reading si = read_quantity(exact(reading.value) + " " + unit, unit);
    fuzz::require(si.fault.empty() && si.value == reading.value, "the SI number has the same bits");
  }
  if (const auto number = plain_number(text)) {
    fuzz::require(plain_number(exact(*number)) == number, "numbers read back");
  }
  return 0;
}
