// Curves over time in a window of Dear ImGui.
#pragma once

#include "stylet/view/frame.hpp"

#include <functional>
#include <string>
#include <vector>

namespace stylet {

struct Curve {
  std::string name;
  unsigned colour = 0;  ///< as IM_COL32
  bool dashed = false;
  std::function<double(const Sample&)> value;
};

/// From the first to the last sample. factor: from SI to the unit that the title names.
void draw_plot(const std::string& title,
               const std::vector<Sample>& samples,
               const std::vector<Curve>& curves,
               double factor,
               float height);

}  // namespace stylet
