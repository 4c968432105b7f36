#include "stylet/view/png.hpp"

#include "stylet/base/errors.hpp"

#include <algorithm>
#include <epoxy/gl.h>
#include <png.h>

namespace stylet {

std::vector<std::uint8_t> read_pixels(int width, int height) {
  const auto row = 3 * static_cast<std::size_t>(width);
  const auto rows = static_cast<std::size_t>(height);
  std::vector<std::uint8_t> upward(row * rows);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, upward.data());
  std::vector<std::uint8_t> pixels(upward.size());
  for (std::size_t i = 0; i < rows; ++i) {
    std::copy_n(upward.begin() + static_cast<std::ptrdiff_t>((rows - 1 - i) * row), row,
                pixels.begin() + static_cast<std::ptrdiff_t>(i * row));
  }
  return pixels;
}

void write_png(const std::string& path,
               int width,
               int height,
               const std::vector<std::uint8_t>& rgb) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  if (png_image_write_to_file(&image, path.c_str(), 0, rgb.data(), 0, nullptr) != 0) return;
  throw IoError(path + ": cannot be written: " + image.message);
}

}  // namespace stylet
