#include "stylet/simulation/score.hpp"

#include "stylet/scene/check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace stylet {

namespace {

std::optional<double> error_of(const SeedScore& seed) {
  if (seed.error_at_rest) return seed.error_at_rest;
  return std::isnan(seed.error_now) ? std::nullopt : std::optional(seed.error_now);
}

std::string line(const std::string& what, double value, const std::string& unit) {
  char text[40];
  std::snprintf(text, sizeof text, ": %.3g ", value);
  return what + text + unit + '\n';
}

}  // namespace

Score score_of(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  Score score;
  std::vector<EmbeddedPoint> places;
  for (const Seed& seed : simulation.seeds()) places.push_back(simulation.place_of(seed));
  const auto world = simulation.body().world(places);
  Scene loads = scene;  // a needle that is still in will come out
  loads.needles.clear();
  const bool comes_to_rest = why_not_at_rest(loads).empty();
  double sum = 0;
  int n = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Seed& seed = simulation.seeds()[i];
    const auto target = std::ranges::find(scene.targets, seed.target, &Target::name);
    SeedScore entry{seed.target, seed.time, std::nan(""), {}, seed.turned_over};
    if (target != scene.targets.end()) {
      entry.error_now = distance(world[i], *target);
      if (comes_to_rest) entry.error_at_rest = distance(places[i].x, *target);
    }
    if (const auto error = error_of(entry)) {
      sum += *error;
      ++n;
      score.largest_error = std::max(score.largest_error.value_or(0), *error);
    }
    score.seeds.push_back(std::move(entry));
  }
  if (n > 0) score.mean_error = sum / n;
  for (const Target& target : scene.targets) {
    if (std::ranges::find(score.seeds, target.name, &SeedScore::target) == score.seeds.end()) {
      score.missed.push_back(target.name);
    }
  }
  score.largest_force = simulation.counts().peak_needle_force;
  score.time = simulation.time();
  return score;
}

std::string distrust(int turned_over) {
  if (turned_over == 0) return {};
  return ", NOT TO BE TRUSTED: beyond small strain, triangles turned over: " +
         std::to_string(turned_over);
}

std::string text_of(const Score& score) {
  std::string text;
  for (const SeedScore& seed : score.seeds) {
    const auto error = error_of(seed);
    if (!error) continue;
    text += line("seed for '" + seed.target + "' at rest", 1e3 * *error,
                 "mm off" + distrust(seed.turned_over));
  }
  for (const auto& target : score.missed) text += "target '" + target + "' has no seed\n";
  const auto most = std::ranges::max_element(score.seeds, {}, &SeedScore::turned_over);
  const std::string doubt = most == score.seeds.end() ? "" : distrust(most->turned_over);
  if (score.mean_error) text += line("mean error", 1e3 * *score.mean_error, "mm" + doubt);
  text += line("largest force", score.largest_force, "N");
  text += line("time", score.time, "s");
  return text;
}

nlohmann::ordered_json json_of(const Score& score) {
  nlohmann::ordered_json json;
  json["seeds"] = nlohmann::ordered_json::array();
  for (const SeedScore& seed : score.seeds) {
    nlohmann::ordered_json entry{
        {"target", seed.target}, {"time", seed.time}, {"turned_over", seed.turned_over}};
    if (!std::isnan(seed.error_now)) entry["error_now"] = seed.error_now;
    if (seed.error_at_rest) entry["error_at_rest"] = *seed.error_at_rest;
    json["seeds"].push_back(std::move(entry));
  }
  json["missed"] = score.missed;
  if (score.mean_error) json["mean_error"] = *score.mean_error;
  if (score.largest_error) json["largest_error"] = *score.largest_error;
  json["largest_force"] = score.largest_force;
  json["time"] = score.time;
  return json;
}

}  // namespace stylet
