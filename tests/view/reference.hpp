// The reference scene in a hand's reach.
#pragma once

#include "stylet/view/live_run.hpp"

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace stylet {

inline LiveOptions reference_options(const std::vector<std::string>& overrides) {
  const std::string file = STYLET_SOURCE_DIR "/input/prostate.yaml";
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return {{file, text.str(), overrides}};
}

}  // namespace stylet
