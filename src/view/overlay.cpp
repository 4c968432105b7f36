#include "stylet/view/overlay.hpp"

#include "stylet/geometry/rotation.hpp"
#include "stylet/view/colour_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <imgui.h>
#include <vector>

namespace stylet {

namespace {

// After Okabe and Ito: told apart by who sees no red or no green.
constexpr ImU32 black = IM_COL32(0, 0, 0, 255);
constexpr ImU32 white = IM_COL32(255, 255, 255, 255);
constexpr ImU32 sky_blue = IM_COL32(86, 180, 233, 255);
constexpr ImU32 green = IM_COL32(0, 190, 140, 255);
constexpr ImU32 yellow = IM_COL32(240, 228, 66, 255);
constexpr ImU32 vermilion = IM_COL32(213, 94, 0, 255);
constexpr ImU32 steel = IM_COL32(225, 230, 235, 255);
constexpr ImU32 shade = IM_COL32(0, 0, 0, 150);

class Overlay {
 public:
  Overlay(const Frame& frame, const OverlayLook& look, const Camera& camera)
      : frame_(frame),
        look_(look),
        camera_(camera),
        unit_(static_cast<float>(look.size)),
        list_(*ImGui::GetBackgroundDrawList()) {}

  void draw() {
    const Pane& pane = camera_.pane();
    list_.PushClipRect(to_vec({pane.left, pane.top}),
                       to_vec({pane.left + pane.width, pane.top + pane.height}));
    membrane();
    planned();
    targets();
    if (!frame_.needle.in_tissue) guide();
    needle();
    if (look_.contacts) contacts();
    seeds();
    scale_bar();
    if (frame_.colouring != Colouring::none) colour_bar();
    list_.PopClipRect();
  }

 private:
  static ImVec2 to_vec(Pixel p) { return {static_cast<float>(p.x), static_cast<float>(p.y)}; }
  [[nodiscard]] ImVec2 at(WorldPoint x) const { return to_vec(camera_.pixel_of(x)); }

  void line(ImVec2 a, ImVec2 b, ImU32 colour, float width) {
    list_.AddLine(a, b, shade, (width + 2) * unit_);
    list_.AddLine(a, b, colour, width * unit_);
  }

  void text(ImVec2 where, ImU32 colour, const std::string& words) {
    for (const auto& [x, y] : {std::pair{1.F, 1.F}, {-1.F, 1.F}, {1.F, -1.F}, {-1.F, -1.F}}) {
      list_.AddText({where.x + x, where.y + y}, black, words.c_str());
    }
    list_.AddText(where, colour, words.c_str());
  }

  void membrane() {
    std::vector<ImVec2> points;
    for (const auto& x : frame_.membrane) points.push_back(at(x));
    if (points.empty()) return;
    const int n = static_cast<int>(points.size());
    list_.AddPolyline(points.data(), n, shade, ImDrawFlags_Closed, 4 * unit_);
    list_.AddPolyline(points.data(), n, sky_blue, ImDrawFlags_Closed, 2 * unit_);
  }

  void targets() {
    for (const auto& target : frame_.targets) {
      const ImVec2 c = at(target.x);
      const float r = 8 * unit_;
      line({c.x - r, c.y}, {c.x + r, c.y}, white, 2);
      line({c.x, c.y - r}, {c.x, c.y + r}, white, 2);
      if (!target.has_seed) list_.AddCircle(c, 1.5F * r, white, 0, 1.5F * unit_);
      if (look_.names) text({c.x + 1.2F * r, c.y - 2.2F * r}, white, target.name);
    }
  }

  void dashed(ImVec2 from, ImVec2 to, ImU32 colour, float width) {
    const float length = std::hypot(to.x - from.x, to.y - from.y);
    const float dash = 8 * unit_;
    const ImVec2 d{(to.x - from.x) / length, (to.y - from.y) / length};
    for (float s = 0; s < length; s += 2 * dash) {
      const float end = std::min(s + dash, length);
      list_.AddLine({from.x + s * d.x, from.y + s * d.y}, {from.x + end * d.x, from.y + end * d.y},
                    colour, width * unit_);
    }
  }

  // Ways of needles, and rings where their tips should be when a seed is left.
  void planned() {
    for (const PlannedWay& way : look_.planned) {
      dashed(at(way.skin), at(way.deepest), yellow, 2);
      for (const auto& seed : way.seeds) {
        list_.AddCircle(at(seed.tip), 6 * unit_, black, 0, 4 * unit_);
        list_.AddCircle(at(seed.tip), 6 * unit_, yellow, 0, 2 * unit_);
      }
    }
  }

  // The way that a needle outside would take.
  void guide() {
    constexpr double far = 0.5;  // m
    dashed(at(frame_.needle.tip), at(frame_.needle.tip + far * direction()),
           IM_COL32(255, 255, 255, 90), 1);
  }

  [[nodiscard]] Vector2 direction() const {
    return {std::cos(frame_.needle_angle), std::sin(frame_.needle_angle)};
  }

  void needle() {
    const double length = 2 * camera_.metres_per_pixel() * camera_.pane().width;
    const ImVec2 tip = at(frame_.needle.tip);
    const ImVec2 hub = at(frame_.needle.tip - length * direction());
    line(tip, hub, steel, 3);
    // The point of a needle.
    const float away = std::hypot(hub.x - tip.x, hub.y - tip.y);
    const ImVec2 d{(tip.x - hub.x) / away, (tip.y - hub.y) / away};
    const float r = 5 * unit_;
    const ImU32 colour = frame_.needle.at_membrane ? vermilion : steel;
    const ImVec2 base{tip.x - 2 * r * d.x, tip.y - 2 * r * d.y};
    list_.AddTriangleFilled(tip, {base.x - r * d.y, base.y + r * d.x},
                            {base.x + r * d.y, base.y - r * d.x}, colour);
    list_.AddTriangle(tip, {base.x - r * d.y, base.y + r * d.x},
                      {base.x + r * d.y, base.y - r * d.x}, black, unit_);
  }

  // Discs stick, diamonds slide.
  void contacts() {
    for (const auto& point : frame_.needle.shaft) {
      const ImVec2 c = at(point.x);
      const float r = 4 * unit_;
      if (point.sticks) {
        list_.AddCircleFilled(c, r, green);
        list_.AddCircle(c, r, black, 0, unit_);
      } else {
        list_.AddQuadFilled({c.x - 1.3F * r, c.y}, {c.x, c.y - 1.3F * r}, {c.x + 1.3F * r, c.y},
                            {c.x, c.y + 1.3F * r}, yellow);
        list_.AddQuad({c.x - 1.3F * r, c.y}, {c.x, c.y - 1.3F * r}, {c.x + 1.3F * r, c.y},
                      {c.x, c.y + 1.3F * r}, black, unit_);
      }
    }
  }

  void seeds() {
    for (const auto& seed : frame_.seeds) {
      const ImVec2 c = at(seed.x);
      const float r = 5 * unit_;
      const auto target = std::ranges::find(frame_.targets, seed.target, &ShownTarget::name);
      if (target != frame_.targets.end()) list_.AddLine(c, at(target->x), vermilion, 1.5F * unit_);
      list_.AddRectFilled({c.x - r, c.y - r}, {c.x + r, c.y + r}, vermilion);
      list_.AddRect({c.x - r, c.y - r}, {c.x + r, c.y + r}, white, 0, 0, 1.5F * unit_);
      if (!look_.names || !seed.error_now) continue;
      char words[40];
      std::snprintf(words, sizeof words, "%.1f mm", 1e3 * *seed.error_now);
      text({c.x - 3 * r, c.y + 1.6F * r}, white, words);
    }
  }

  void scale_bar() {
    constexpr std::array lengths{0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005};
    const Pane& pane = camera_.pane();
    const double widest = 0.25 * pane.width * camera_.metres_per_pixel();
    const auto* length = std::ranges::find_if(lengths, [&](double l) { return l <= widest; });
    if (length == lengths.end()) return;
    const ImVec2 a = to_vec({pane.left + 16 * unit_, pane.top + pane.height - 16 * unit_});
    const ImVec2 b{a.x + static_cast<float>(*length / camera_.metres_per_pixel()), a.y};
    line(a, b, white, 3);
    char words[20];
    std::snprintf(words, sizeof words, "%g mm", 1e3 * *length);
    text({a.x, a.y - 1.4F * ImGui::GetFontSize()}, white, words);
  }

  void colour_bar() {
    const bool length = frame_.colouring == Colouring::displacement;
    const Pane& pane = camera_.pane();
    const float width = 12 * unit_;
    const float height = 140 * unit_;
    const ImVec2 top = to_vec({pane.left + 16 * unit_, pane.top + 3 * ImGui::GetFontSize()});
    const auto n = viridis.size() - 1;
    const auto colour = [](std::size_t i) {
      return IM_COL32(viridis[i][0], viridis[i][1], viridis[i][2], 255);
    };
    for (std::size_t i = 0; i < n; ++i) {
      const float y = top.y + height * static_cast<float>(n - 1 - i) / static_cast<float>(n);
      list_.AddRectFilledMultiColor({top.x, y}, {top.x + width, y + height / static_cast<float>(n)},
                                    colour(i + 1), colour(i + 1), colour(i), colour(i));
    }
    list_.AddRect(top, {top.x + width, top.y + height}, white);
    text({top.x, top.y - 1.4F * ImGui::GetFontSize()}, white,
         length ? "displacement, mm" : "von Mises stress, kPa");
    char words[24];
    const double factor = length ? 1e3 : 1e-3;
    std::snprintf(words, sizeof words, "%.3g", factor * look_.largest);
    text({top.x + 1.5F * width, top.y - 0.3F * ImGui::GetFontSize()}, white, words);
    text({top.x + 1.5F * width, top.y + height - 0.7F * ImGui::GetFontSize()}, white, "0");
  }

  const Frame& frame_;
  const OverlayLook& look_;
  const Camera& camera_;
  float unit_;
  ImDrawList& list_;
};

}  // namespace

void draw_overlay(const Frame& frame, const OverlayLook& look, const Camera& camera) {
  Overlay(frame, look, camera).draw();
}

}  // namespace stylet
