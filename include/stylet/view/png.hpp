// Pictures of what is drawn, as PNG files.
#pragma once

#include <string>

namespace stylet {

/// The bound framebuffer. Throws IoError.
void save_framebuffer(const std::string& path, int width, int height);

}  // namespace stylet
