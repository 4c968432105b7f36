// A scene as text, so that it can be made again with another method or parameter.
#pragma once

#include "stylet/scene/loader.hpp"

#include <string>
#include <vector>

namespace stylet {

struct SceneSource {
  std::string file;  ///< for messages and paths
  std::string text;
  std::vector<std::string> overrides = {};

  [[nodiscard]] Scene load() const { return load_scene(file, text, overrides); }
};

}  // namespace stylet
