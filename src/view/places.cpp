#include "stylet/view/places.hpp"

#include "stylet/base/errors.hpp"

#include <nlohmann/json.hpp>

#include <fstream>

namespace stylet {

void write_places(const std::string& path, const Frame& frame, const Camera& camera) {
  const auto point = [](auto x) { return nlohmann::ordered_json{x.x, x.y}; };
  nlohmann::ordered_json places;
  places["time"] = frame.time;
  places["method"] = frame.method;
  const Pane& pane = camera.pane();
  places["camera"] = {{"centre", point(camera.centre())},
                      {"metres_per_pixel", camera.metres_per_pixel()},
                      {"pane", {pane.left, pane.top, pane.width, pane.height}}};
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
    places["seeds"].push_back(entry);
  }
  for (const auto& target : frame.targets) places["targets"][target.name] = point(target.x);
  for (const auto& x : frame.membrane) places["membrane"].push_back(point(x));
  for (const auto& shaft : frame.needle.shaft) places["shaft"].push_back(point(shaft.x));
  places["notice"] = frame.notice;
  places["error"] = frame.error;
  std::ofstream out(path);
  out << places.dump(1) << '\n';
  if (!out.flush()) throw IoError(path + ": cannot be written");
}

}  // namespace stylet
