#include "stylet/view/places.hpp"

#include "stylet/base/errors.hpp"

#include <nlohmann/json.hpp>

#include <fstream>

namespace stylet {

void write_places(const std::string& path,
                  const Frame& frame,
                  const Camera& camera,
                  const std::map<std::string, Pane>& widgets) {
  const auto point = [](auto x) { return nlohmann::ordered_json{x.x, x.y}; };
  nlohmann::ordered_json places;
  places["time"] = frame.time;
  places["method"] = frame.method;
  places["method_reason"] = frame.method_reason;
  const auto rectangle = [](const Pane& pane) {
    return nlohmann::ordered_json{pane.left, pane.top, pane.width, pane.height};
  };
  places["camera"] = {{"centre", point(camera.centre())},
                      {"metres_per_pixel", camera.metres_per_pixel()},
                      {"pane", rectangle(camera.pane())}};
  for (const auto& [name, pane] : widgets) places["widgets"][name] = rectangle(pane);
  for (const ShownParameter& parameter : frame.parameters) {
    places["parameters"][parameter.key] = {
        {"value", parameter.value}, {"low", parameter.low}, {"high", parameter.high}};
  }
  places["needle"] = {{"tip", point(frame.needle.tip)},
                      {"in_tissue", frame.needle.in_tissue},
                      {"phase", frame.needle.phase},
                      {"force", frame.tip_force + frame.shaft_force}};
  places["seeds"] = nlohmann::ordered_json::array();
  for (const auto& seed : frame.seeds) {
    nlohmann::ordered_json entry{{"world", point(seed.x)}, {"target", seed.target}};
    if (seed.error_now) entry["error_now"] = *seed.error_now;
    if (seed.error_at_rest) entry["error_at_rest"] = *seed.error_at_rest;
    if (seed.band) entry["band"] = *seed.band;
    entry["turned_over"] = seed.turned_over;
    places["seeds"].push_back(entry);
  }
  for (const auto& target : frame.targets) places["targets"][target.name] = point(target.x);
  for (const auto& x : frame.membrane) places["membrane"].push_back(point(x));
  for (const auto& shaft : frame.needle.shaft) places["shaft"].push_back(point(shaft.x));
  places["turned_over"] = {{"now", frame.inverted}, {"most", frame.most_inverted}};
  places["notes"] = frame.notes;
  places["notice"] = frame.notice;
  places["error"] = frame.error;
  std::ofstream out(path);
  out << places.dump(1) << '\n';
  if (!out.flush()) throw IoError(path + ": cannot be written");
}

}  // namespace stylet
