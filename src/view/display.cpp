#include "stylet/view/display.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/view/overlay.hpp"

#include <algorithm>
#include <backends/imgui_impl_opengl3.h>
#include <cmath>
#include <filesystem>
#include <imgui.h>
#include <vector>

namespace stylet {

namespace {

constexpr float letter = 15;  // pixels at size 1
// Drawn larger than shown, so that they stay sharp on a projector.
constexpr float oversize = 2;

// The largest value but for a hundredth of the triangles: a tip's peak would leave the rest dark.
double scale_of(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Up to the next 1, 2 or 5 times a power of ten, so that the scale does not flicker.
double round_up(double value) {
  if (value <= 0) return 0;
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (value <= step * power) return step * power;
  }
  return 10 * power;
}

}  // namespace

Interface::Interface() {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // no file where the program happens to run
  const char* const font = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  if (std::filesystem::exists(font)) io.Fonts->AddFontFromFileTTF(font, oversize * letter);
  ImGui::StyleColorsDark();
}

Interface::~Interface() {
  ImGui::DestroyContext();
}

Display::Display(const Picture& picture) : tissue_(picture) {
  if (!ImGui_ImplOpenGL3_Init("#version 330 core")) {
    throw Error(ExitCode::other, "Dear ImGui cannot use this OpenGL");
  }
}

Display::~Display() {
  ImGui_ImplOpenGL3_Shutdown();
}

void Display::resize(double width, double height) {
  width_ = width;
  height_ = height;
  camera.show_in({0, 0, width - panel_width(look, width), height});
}

void Display::fit(const Frame& frame) {
  constexpr double room = 0.02;  // m
  auto points = frame.reference;
  points.push_back(static_cast<float>(frame.needle.skin.x - room * std::cos(frame.needle_angle)));
  points.push_back(static_cast<float>(frame.needle.skin.y - room * std::sin(frame.needle_angle)));
  camera.fit(points);
}

Wishes Display::draw(const Frame& frame, const DrawingPace& pace, bool paused) {
  ImGuiIO& io = ImGui::GetIO();
  const bool has_letters = io.Fonts->Fonts.Size > 0 && io.Fonts->Fonts[0]->FontSize > letter;
  io.FontGlobalScale = static_cast<float>(look.size) / (has_letters ? oversize : 1);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
  const double ratio = io.DisplayFramebufferScale.x;

  if (frame.colouring != scaled_) largest_ = 0;
  scaled_ = frame.colouring;
  largest_ = std::max(largest_, round_up(scale_of(frame.colour)));

  const double panel = panel_width(look, width_);
  const Pane beside{width_ - panel, 0, panel, height_};
  Wishes wishes = draw_panel(frame, pace, paused, beside, look);
  for (auto& order : draw_messages(frame, camera.pane()).orders) {
    wishes.orders.push_back(std::move(order));
  }
  draw_help(camera.pane(), look);
  draw_overlay(frame, {look.contacts, look.names, look.size, largest_, planned}, camera);
  ImGui::Render();

  glViewport(0, 0, static_cast<GLsizei>(std::lround(ratio * width_)),
             static_cast<GLsizei>(std::lround(ratio * height_)));
  glClearColor(0.04F, 0.04F, 0.06F, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  tissue_.draw(frame, {look.picture, look.edges, largest_}, camera, ratio, height_);
  glViewport(0, 0, static_cast<GLsizei>(std::lround(ratio * width_)),
             static_cast<GLsizei>(std::lround(ratio * height_)));
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  return wishes;
}

}  // namespace stylet
