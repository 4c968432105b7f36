// Where things are in a picture, beside it as JSON: what a test or a report measures in it.
#pragma once

#include "stylet/view/camera.hpp"
#include "stylet/view/frame.hpp"

#include <string>

namespace stylet {

/// In the scene's frame, SI units; the camera tells which pixel a point is in. Throws IoError.
void write_places(const std::string& path, const Frame& frame, const Camera& camera);

}  // namespace stylet
