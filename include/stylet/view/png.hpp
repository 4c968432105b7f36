// Pictures as PNG files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace stylet {

/// The bound framebuffer: red, green, blue, row by row from the top.
[[nodiscard]] std::vector<std::uint8_t> read_pixels(int width, int height);

/// rgb: as of read_pixels. Throws IoError.
void write_png(const std::string& path,
               int width,
               int height,
               const std::vector<std::uint8_t>& rgb);

}  // namespace stylet
