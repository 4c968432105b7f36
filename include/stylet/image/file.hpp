// Pictures as files: PNG and JPEG.
#pragma once

#include "stylet/image/picture.hpp"

#include <string>

namespace stylet {

/// Pixels of a PNG or a JPEG, which its first bytes tell; grey or colours as it has them, without its
/// rectangle. Throws InputError, with the name, for anything else, a damaged one, or one with a side
/// above 16384 pixels.
[[nodiscard]] Picture read_picture(const std::string& name, const std::string& bytes);

/// Bytes of a PNG file. Throws IoError.
[[nodiscard]] std::string png_of(const Picture& picture);

}  // namespace stylet
