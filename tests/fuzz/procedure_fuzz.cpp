// The rows of a recorded procedure, with a last one that may be torn.
#include "stylet/scene/procedure.hpp"

#include "fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stylet;
  fuzz::may_refuse([&] {
    std::string note;
    std::string text;
    for (const auto& row : read_procedure("p", fuzz::text_of(data, size), note)) {
      text += to_line(row);
    }
    std::string again;
    try {
      for (const auto& row : read_procedure("p", text, note)) again += to_line(row);
    } catch (const InputError& error) {
      std::fprintf(stderr, "%s\n%s", error.what(), text.c_str());
    }
    fuzz::require(again == text && note.empty(), "rows read back as they were written");
  });
  return 0;
}
