#include "stylet/view/panel.hpp"

#include "stylet/base/text.hpp"
#include "stylet/base/units.hpp"
#include "stylet/view/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <imgui.h>
#include <optional>
#include <string>
#include <utility>

namespace stylet {

namespace {

constexpr ImU32 orange = IM_COL32(230, 159, 0, 255);
constexpr ImU32 sky_blue = IM_COL32(86, 180, 233, 255);
constexpr ImU32 green = IM_COL32(0, 190, 140, 255);
constexpr ImU32 white = IM_COL32(240, 240, 240, 255);
const ImVec4 warning{1.0F, 0.75F, 0.25F, 1.0F};

constexpr ImGuiWindowFlags fixed_window = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                          ImGuiWindowFlags_NoCollapse |
                                          ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav;

void place(const Pane& pane) {
  ImGui::SetNextWindowPos({static_cast<float>(pane.left), static_cast<float>(pane.top)});
  ImGui::SetNextWindowSize({static_cast<float>(pane.width), static_cast<float>(pane.height)});
}

template <class... Values>
void row(const char* name, const char* format, Values... values) {
  ImGui::TextUnformatted(name);
  ImGui::SameLine(0.45F * ImGui::GetWindowWidth());
  ImGui::Text(format, values...);
}

std::string length_text(const std::optional<double>& metres) {
  if (!metres) return "unknown";
  char text[40];
  std::snprintf(text, sizeof text, "%.2f mm", 1e3 * *metres);
  return text;
}

void placement(const Frame& frame) {
  for (const ShownTarget& target : frame.targets) {
    if (!target.has_seed) row(target.name.c_str(), "%s", "no seed yet");
  }
  for (const ShownSeed& seed : frame.seeds) {
    if (seed.target.empty()) {
      row(seed.needle.c_str(), "%s", "a seed without a target");
      continue;
    }
    ImGui::TextUnformatted(("seed for " + seed.target).c_str());
    row("  error now", "%.2f mm", 1e3 * seed.error_now.value_or(0));
    row("  at rest", "%s", length_text(seed.error_at_rest).c_str());
    row("  its band", "%s", seed.band ? ("± " + length_text(seed.band)).c_str() : "unknown");
  }
}

void forces(const Frame& frame) {
  row("tip", "%.2f N%s", frame.tip_force, frame.needle.at_membrane ? " at the capsule" : "");
  row("shaft", "%.2f N", frame.shaft_force);
  row("largest so far", "%.2f N", frame.peak_force);
  if (frame.inverted > 0) {
    ImGui::TextColored(warning, "beyond small strain: %d triangles turned over", frame.inverted);
  }
  row("shaft points", "%d stick, %d slide", frame.n_stick, frame.n_slip);
  const float height = 5 * ImGui::GetFontSize();
  draw_plot("N", frame.history,
            {{"tip", orange, false, [](const Sample& s) { return s.tip_force; }},
             {"shaft", sky_blue, true, [](const Sample& s) { return s.shaft_force; }},
             {"sum", white, false, [](const Sample& s) { return s.tip_force + s.shaft_force; }}},
            1, height);
  draw_plot("mJ", frame.history,
            {{"work", white, false, [](const Sample& s) { return s.external; }},
             {"lost", orange, true, [](const Sample& s) { return s.dissipated; }},
             {"strain", sky_blue, false, [](const Sample& s) { return s.strain; }},
             {"kinetic", green, true, [](const Sample& s) { return s.kinetic; }}},
            1e3, height);
}

void pace_of(const Frame& frame, const DrawingPace& drawing, bool paused) {
  const Pace& pace = frame.pace;
  row("time", "%.2f s", frame.time);
  row("step", "%.3g ms, %.3g sub-steps", 1e3 * pace.step, pace.sub_steps);
  if (drawing.frames_per_second <= 0) return;
  row("frames", "%.0f a second", drawing.frames_per_second);
  row("sub-steps a frame", "%.1f",
      pace.real_time_factor * pace.sub_steps / pace.step / drawing.frames_per_second);
  row("busy with steps", "%.0f %%", 100 * pace.busy);
  if (drawing.delay > 0) row("hand to picture", "%.0f ms", 1e3 * drawing.delay);
  constexpr double slow = 0.97;
  if (paused || !frame.error.empty()) {
    row("real time", "%s", "stands still");
  } else if (pace.real_time_factor < slow) {
    ImGui::TextColored(warning, "slower than real time: %.2f x", pace.real_time_factor);
    if (frame.method != "quasi_static") ImGui::TextUnformatted("quasi_static is quicker (M)");
  } else {
    row("real time", "%.2f x", pace.real_time_factor);
  }
}

void method(const Frame& frame, Wishes& wishes) {
  constexpr std::array names{"implicit", "quasi_static", "explicit"};
  ImGui::TextUnformatted("method (starts anew)");
  for (const char* name : names) {
    if (ImGui::RadioButton(name, frame.method == name) && frame.method != name) {
      wishes.orders.emplace_back([name](LiveRun& run) { run.choose_method(name); });
    }
    if (name != names.back()) ImGui::SameLine();
  }
}

// The last part of a key, of regions with their name.
std::string short_name(const std::string& key) {
  const auto names = parse_path(key).names;
  std::string text = names.back();
  if (names.size() > 3) text = names[2] + ": " + text;
  std::ranges::replace(text, '_', ' ');
  return text;
}

void sliders(const Frame& frame, Wishes& wishes) {
  for (const ShownParameter& parameter : frame.parameters) {
    const std::string unit = parameter.unit.empty() ? "" : customary_unit(parameter.unit);
    const double factor = unit.empty() ? 1 : to_si("1 " + unit, parameter.unit);
    auto value = static_cast<float>(parameter.value / factor);
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(
        (short_name(parameter.key) + (parameter.new_operator ? " *" : "")).c_str());
    ImGui::SameLine(0.55F * ImGui::GetWindowWidth());
    ImGui::SetNextItemWidth(-1);
    ImGui::SliderFloat(("##" + parameter.key).c_str(), &value,
                       static_cast<float>(parameter.low / factor),
                       static_cast<float>(parameter.high / factor), ("%.3g " + unit).c_str(),
                       parameter.low > 0 ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None);
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("%s\n%s", parameter.key.c_str(), parameter.doc.c_str());
    }
    if (ImGui::IsItemDeactivatedAfterEdit()) {
      wishes.orders.emplace_back(
          [key = parameter.key, si = factor * value](LiveRun& run) { run.change(key, si); });
    }
  }
}

void looks(Look& look) {
  ImGui::Checkbox("picture", &look.picture);
  ImGui::SameLine();
  ImGui::Checkbox("mesh", &look.edges);
  ImGui::SameLine();
  ImGui::Checkbox("contacts", &look.contacts);
  int colouring = static_cast<int>(look.colouring);
  ImGui::RadioButton("no colours", &colouring, 0);
  ImGui::SameLine();
  ImGui::RadioButton("displacement", &colouring, 1);
  ImGui::SameLine();
  ImGui::RadioButton("stress", &colouring, 2);
  look.colouring = static_cast<Colouring>(colouring);
}

}  // namespace

double panel_width(const Look& look, double window_width) {
  constexpr double letters = 340;  // pixels at size 1
  constexpr double most = 0.4;
  return look.panel ? std::min(letters * look.size, most * window_width) : 0;
}

Wishes draw_panel(
    const Frame& frame, const DrawingPace& pace, bool paused, const Pane& pane, Look& look) {
  Wishes wishes;
  if (!look.panel) return wishes;
  place(pane);
  ImGui::Begin("Stylet", nullptr, fixed_window | ImGuiWindowFlags_NoTitleBar);
  if (ImGui::Button(paused ? "Go on (P)" : "Pause (P)")) wishes.pause = true;
  ImGui::SameLine();
  if (ImGui::Button("Undo (U)")) wishes.orders.emplace_back([](LiveRun& run) { run.undo(); });
  ImGui::SameLine();
  if (ImGui::Button("Anew (R)")) wishes.orders.emplace_back([](LiveRun& run) { run.restart(); });
  ImGui::SameLine();
  if (ImGui::Button("Keys (H)")) look.help = !look.help;
  row("needle", "%s%s", frame.needle.phase.c_str(), frame.replays ? ", recorded" : "");
  if (ImGui::CollapsingHeader("Placement", ImGuiTreeNodeFlags_DefaultOpen)) placement(frame);
  if (ImGui::CollapsingHeader("Forces", ImGuiTreeNodeFlags_DefaultOpen)) forces(frame);
  if (ImGui::CollapsingHeader("Time", ImGuiTreeNodeFlags_DefaultOpen)) {
    pace_of(frame, pace, paused);
    method(frame, wishes);
  }
  if (ImGui::CollapsingHeader("Tissue and needle", ImGuiTreeNodeFlags_DefaultOpen)) {
    sliders(frame, wishes);
    ImGui::TextDisabled("* makes the tissue's matrices anew");
  }
  if (ImGui::CollapsingHeader("What is shown", ImGuiTreeNodeFlags_DefaultOpen)) looks(look);
  ImGui::End();
  return wishes;
}

Wishes draw_messages(const Frame& frame, const Pane& pane) {
  Wishes wishes;
  const bool failed = !frame.error.empty();
  if (!failed && frame.notice.empty()) return wishes;
  const float margin = ImGui::GetFontSize();
  ImGui::SetNextWindowPos(
      {static_cast<float>(pane.left) + 9 * margin, static_cast<float>(pane.top) + 0.5F * margin});
  ImGui::SetNextWindowSize({static_cast<float>(pane.width) - 10 * margin, 0});
  ImGui::SetNextWindowBgAlpha(failed ? 0.95F : 0.7F);
  ImGui::Begin("message", nullptr,
               fixed_window | ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoFocusOnAppearing);
  if (failed) {
    ImGui::PushStyleColor(ImGuiCol_Text, warning);
    ImGui::TextWrapped("The simulation stopped: %s", frame.error.c_str());
    ImGui::PopStyleColor();
    if (frame.can_undo && ImGui::Button("Undo the last seed or needle (U)")) {
      wishes.orders.emplace_back([](LiveRun& run) { run.undo(); });
    }
    ImGui::SameLine();
    if (ImGui::Button("All anew (R)"))
      wishes.orders.emplace_back([](LiveRun& run) { run.restart(); });
  } else {
    ImGui::TextWrapped("%s", frame.notice.c_str());
  }
  ImGui::End();
  return wishes;
}

void draw_help(const Pane& pane, Look& look) {
  if (!look.help) return;
  constexpr std::array<std::pair<const char*, const char*>, 18> keys{
      {{"mouse, left button", "hold the needle: push and pull it"},
       {"mouse, no button", "choose a height while the needle is outside"},
       {"mouse, right button", "leave a seed at the tip"},
       {"mouse, wheel", "closer, further"},
       {"mouse, middle button", "move the picture; also Shift and left button"},
       {"arrows along the needle", "push and pull; with Shift slowly"},
       {"arrows across the needle", "height; with Shift in small steps"},
       {"Space", "leave a seed at the tip"},
       {"U", "undo the last seed or needle"},
       {"R", "all anew"},
       {"P", "pause, go on"},
       {"M", "next method: implicit, quasi_static, explicit; starts anew"},
       {"C, T, G, K", "colours, picture, mesh, contacts"},
       {"+, -, W A S D, F", "closer, further, move, whole tissue"},
       {"[ and ]", "speed limit of the hand"},
       {"Ctrl with + or -", "size of letters"},
       {"B, X", "panel; save a picture of the window"},
       {"H", "this list"}}};
  const float letter = ImGui::GetFontSize();
  ImGui::SetNextWindowPos({static_cast<float>(pane.left + 0.5 * pane.width),
                           static_cast<float>(pane.top + 0.5 * pane.height)},
                          0, {0.5F, 0.5F});
  ImGui::SetNextWindowBgAlpha(0.92F);
  ImGui::Begin("Keys", &look.help, fixed_window | ImGuiWindowFlags_AlwaysAutoResize);
  for (const auto& [key, what] : keys) {
    ImGui::TextUnformatted(key);
    ImGui::SameLine(13 * letter);
    ImGui::TextUnformatted(what);
  }
  ImGui::Separator();
  ImGui::TextUnformatted(
      "discs: the shaft sticks; diamonds: it slides; squares: seeds; crosses: targets");
  ImGui::End();
}

}  // namespace stylet
