#include "stylet/view/png.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/image/file.hpp"

#include <algorithm>
#include <epoxy/gl.h>
#include <fstream>

namespace stylet {

void save_framebuffer(const std::string& path, int width, int height) {
  Picture picture;
  picture.width = width;
  picture.height = height;
  picture.channels = 3;
  const auto row = 3 * static_cast<std::size_t>(width);
  picture.bytes.resize(row * static_cast<std::size_t>(height));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, picture.bytes.data());
  // OpenGL begins at the lower left corner.
  for (int i = 0; i < height / 2; ++i) {
    const auto upper = picture.bytes.begin() + static_cast<std::ptrdiff_t>(row) * i;
    const auto lower = picture.bytes.begin() + static_cast<std::ptrdiff_t>(row) * (height - 1 - i);
    std::swap_ranges(upper, upper + static_cast<std::ptrdiff_t>(row), lower);
  }
  std::ofstream out(path, std::ios::binary);
  out << png_of(picture);
  if (!out.flush()) throw IoError(path + ": cannot be written");
}

}  // namespace stylet
