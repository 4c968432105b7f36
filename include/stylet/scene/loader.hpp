// From the text of a scene file to a checked Scene in SI units.
#pragma once

#include "stylet/scene/scene.hpp"

#include <string>
#include <vector>

namespace stylet {

/// Parses, applies `key=value` overrides in order, fills in defaults that depend on other keys and
/// checks. `file_name` is for messages and for paths relative to its folder. Throws InputError.
[[nodiscard]] Scene load_scene(const std::string& file_name,
                               const std::string& text,
                               const std::vector<std::string>& overrides = {});

}  // namespace stylet
