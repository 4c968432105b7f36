#include "stylet/simulation/accuracy.hpp"

#include "fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stylet;
  fuzz::may_refuse([&] {
    const Accuracy accuracy("a", fuzz::text_of(data, size));
    for (const char* quantity : {"seeds.0.placement_error", "peak_needle_force"}) {
      for (const int refine : {0, 1, 30}) (void)accuracy.of(quantity, refine, 1e-3);
    }
    (void)accuracy.cheapest(1e-4);
  });
  return 0;
}
