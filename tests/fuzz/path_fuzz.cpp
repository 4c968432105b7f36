#include "stylet/base/text.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/study/parts.hpp"

#include "fuzz.hpp"
#include <nlohmann/json.hpp>

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stylet;
  const std::string text = fuzz::text_of(data, size);
  fuzz::may_refuse([&] {
    const Path path = parse_path(text);
    fuzz::require(path.length == text.size(), "a path is read to its end");
    fuzz::require(parse_path(plain_path(text)).names == path.names, "the plain path is the same");
  });
  fuzz::may_refuse([&] {
    static const nlohmann::ordered_json summary = {
        {"probes", {{"a.b", {1.5, 2.5}}}}, {"seeds", {{{"placement_error", 1}}}}, {"done", true}};
    (void)find_number(summary, text);
  });
  fuzz::may_refuse([&] { (void)parse_part(text); });
  return 0;
}
