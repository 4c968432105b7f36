#include "stylet/view/plot.hpp"

#include <algorithm>
#include <cstdio>
#include <imgui.h>

namespace stylet {

void draw_plot(const std::string& title,
               const std::vector<Sample>& samples,
               const std::vector<Curve>& curves,
               double factor,
               float height) {
  ImGui::TextUnformatted(title.c_str());
  for (const Curve& curve : curves) {
    ImGui::SameLine();
    ImGui::PushStyleColor(ImGuiCol_Text, curve.colour);
    ImGui::TextUnformatted((curve.name + (curve.dashed ? " - -" : "")).c_str());
    ImGui::PopStyleColor();
  }
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  ImGui::Dummy({width, height});
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 end{corner.x + width, corner.y + height};
  list.AddRectFilled(corner, end, IM_COL32(0, 0, 0, 110));
  if (samples.size() < 2) return;
  double low = 0;
  double high = 0;
  for (const Sample& sample : samples) {
    for (const Curve& curve : curves) {
      low = std::min(low, factor * curve.value(sample));
      high = std::max(high, factor * curve.value(sample));
    }
  }
  if (high <= low) high = low + 1;
  const double first = samples.front().time;
  const double duration = std::max(samples.back().time - first, 1e-9);
  const auto place = [&](double time, double value) {
    return ImVec2{corner.x + width * static_cast<float>((time - first) / duration),
                  end.y - height * static_cast<float>((value - low) / (high - low))};
  };
  const float zero = place(first, 0).y;
  list.AddLine({corner.x, zero}, {end.x, zero}, IM_COL32(255, 255, 255, 60));
  std::vector<ImVec2> points;
  for (const Curve& curve : curves) {
    points.clear();
    for (const Sample& sample : samples) {
      const ImVec2 p = place(sample.time, factor * curve.value(sample));
      // One point a pixel is enough.
      if (points.empty() || p.x - points.back().x >= 1) points.push_back(p);
    }
    if (curve.dashed) {
      for (std::size_t i = 0; i + 4 < points.size(); i += 8) {
        list.AddPolyline(&points[i], 5, curve.colour, 0, 2);
      }
    } else {
      list.AddPolyline(points.data(), static_cast<int>(points.size()), curve.colour, 0, 2);
    }
  }
  char words[60];
  std::snprintf(words, sizeof words, "%.3g", high);
  list.AddText({corner.x + 3, corner.y}, IM_COL32(255, 255, 255, 200), words);
  std::snprintf(words, sizeof words, "%.3g", low);
  list.AddText({corner.x + 3, end.y - ImGui::GetFontSize()}, IM_COL32(255, 255, 255, 200), words);
  std::snprintf(words, sizeof words, "%.1f s", samples.back().time);
  list.AddText({end.x - ImGui::CalcTextSize(words).x - 3, end.y - ImGui::GetFontSize()},
               IM_COL32(255, 255, 255, 200), words);
}

}  // namespace stylet
