#include "stylet/view/player.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/units.hpp"
#include "stylet/view/places.hpp"
#include "stylet/view/png.hpp"
#include "stylet/view/publish.hpp"

#include <cstdio>
#include <imgui.h>

namespace stylet {

namespace {

bool* shown(Look& look, const std::string& name) {
  const std::map<std::string, bool*> all{{"picture", &look.picture},   {"mesh", &look.edges},
                                         {"contacts", &look.contacts}, {"names", &look.names},
                                         {"panel", &look.panel},       {"help", &look.help}};
  const auto found = all.find(name);
  if (found == all.end()) {
    throw InputError("'" + name + "'; allowed: picture, mesh, contacts, names, panel, help");
  }
  return found->second;
}

Colouring colouring_of(const std::string& name) {
  if (name == "none") return Colouring::none;
  if (name == "displacement") return Colouring::displacement;
  if (name == "von_mises") return Colouring::von_mises;
  throw InputError("'" + name + "'; allowed: none, displacement, von_mises");
}

double factor_of(const std::string& text) {
  const auto value = plain_number(text);
  if (!value || *value < 0) throw InputError("'" + text + "'; allowed: a number >= 0");
  return *value;
}

}  // namespace

Player::Player(LiveRun& run, Display& display, std::string folder, PictureSize size)
    : run_(run), display_(display), folder_(std::move(folder)), size_(size) {
  push_.height = run_.height();
  display_.resize(size_.width, size_.height);
  publish(run_, Colouring::none, frame_);
  display_.fit(frame_);
}

void Player::obey(const ScriptLine& line) {
  const std::string& name = line.command;
  const std::string& argument = line.argument;
  const int epoch = run_.epoch();
  if (name == "height") push_.height = to_si(argument, "m");
  if (name == "insert") push_.speed = to_si(argument, "m/s");
  if (name == "retract") push_.speed = -to_si(argument, "m/s");
  if (name == "hold") push_.speed = 0;
  if (name == "seed") run_.seed(argument);
  if (name == "limit") run_.change("hand.speed_limit", to_si(argument, "m/s"));
  if (name == "set") change(argument);
  if (name == "method") run_.choose_method(argument);
  if (name == "undo") run_.undo();
  if (name == "restart") run_.restart();
  if (name == "colours") display_.look.colouring = colouring_of(argument);
  if (name == "show") *shown(display_.look, argument) = true;
  if (name == "hide") *shown(display_.look, argument) = false;
  if (name == "letters") display_.look.size = factor_of(argument);
  if (name == "zoom") display_.camera.zoom(factor_of(argument), display_.camera.middle());
  if (name == "fit") display_.fit(frame_);
  if (name == "screenshot") screenshot(argument);
  if (name == "film") {
    film_rate_ = factor_of(argument);
    next_frame_ = time_;
  }
  if (name == "pan") {
    const auto comma = argument.find(',');
    if (comma == std::string::npos)
      throw InputError("'" + argument + "'; allowed: two lengths, such as 1 cm, 0 cm");
    display_.camera.pan({to_si(argument.substr(0, comma), "m"),
                         to_si(argument.substr(argument.find_first_not_of(' ', comma + 1)), "m")});
  }
  if (run_.epoch() != epoch) {
    error_.clear();
    push_.speed = 0;
  }
}

void Player::change(const std::string& text) {
  const auto equals = text.find('=');
  const std::string key = text.substr(0, equals);
  for (const ShownParameter& parameter : parameters_of(run_)) {
    if (equals == std::string::npos || parameter.key != key) continue;
    run_.change(key, to_si(text.substr(equals + 1), parameter.unit));
    return;
  }
  throw InputError("'" + text + "'; allowed: KEY=VALUE with a key that may change");
}

void Player::go_to(double time) {
  const double h = run_.step_length();
  while (time_ + 0.5 * h <= time) {
    if (film_rate_ > 0 && time_ + 0.5 * h >= next_frame_) {
      draw();
      char name[40];
      std::snprintf(name, sizeof name, "/frame_%05d.png", n_frames_++);
      save_framebuffer(folder_ + name, size_.width, size_.height);
      next_frame_ += 1 / film_rate_;
    }
    if (error_.empty()) {
      run_.want(push_);
      try {
        run_.step();
      } catch (const NumericalError& error) {
        error_ = error.what();
      }
    }
    time_ += h;
  }
}

void Player::draw() {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(size_.width), static_cast<float>(size_.height)};
  io.DeltaTime = static_cast<float>(run_.step_length());
  display_.resize(size_.width, size_.height);
  publish(run_, display_.look.colouring, frame_);
  ++frame_.number;
  frame_.error = error_;
  frame_.pace.step = run_.step_length();
  frame_.pace.sub_steps = static_cast<double>(run_.last_step().sub_steps);
  // The first time a window of Dear ImGui learns its size, the second time it uses it.
  (void)display_.draw(frame_, {}, false);
  (void)display_.draw(frame_, {}, false);
}

void Player::screenshot(const std::string& name) {
  if (name.empty() || name.find('/') != std::string::npos) {
    throw InputError("'" + name + "'; allowed: a name of a file, without folder and ending");
  }
  draw();
  save_framebuffer(folder_ + "/" + name + ".png", size_.width, size_.height);
  write_places(folder_ + "/" + name + ".json", frame_, display_.camera);
}

void Player::play(const std::vector<ScriptLine>& lines) {
  for (const ScriptLine& line : lines) {
    go_to(line.time);
    try {
      obey(line);
    } catch (const InputError& error) {
      throw InputError(line.where + ": " + line.command + ": " + error.what());
    }
  }
  if (!error_.empty()) throw NumericalError(error_);
}

}  // namespace stylet
