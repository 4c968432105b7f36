// Files that call themselves pictures.
#include "stylet/image/file.hpp"

#include "fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stylet;
  fuzz::may_refuse([&] {
    const Picture picture = read_picture("p", fuzz::text_of(data, size));
    const auto pixels = static_cast<std::size_t>(picture.width) *
                        static_cast<std::size_t>(picture.height) *
                        static_cast<std::size_t>(picture.channels);
    fuzz::require(picture.bytes.size() == pixels, "a picture has all of its pixels");
    if (pixels > 1000000) return;
    const Picture again = read_picture("p", png_of(picture));
    fuzz::require(again.bytes == picture.bytes, "a picture reads back");
  });
  return 0;
}
