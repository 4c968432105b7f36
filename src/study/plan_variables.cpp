#include "stylet/study/plan_variables.hpp"

#include <algorithm>

namespace stylet {

namespace {

bool is_stop(const Action& action) {
  return action.kind == ActionKind::insert || action.kind == ActionKind::retract;
}

}  // namespace

PlanVariables::PlanVariables(const Scene& scene, std::size_t needle, const PlanOptions& options)
    : needle_(needle), options_(options) {
  const auto& motion = scene.needles[needle].motion;
  for (std::size_t i = 0; i < motion.size(); ++i) {
    if (motion[i].kind != ActionKind::implant || motion[i].target.empty()) continue;
    std::size_t stop = i;
    while (stop > 0 && !is_stop(motion[stop])) --stop;
    if (is_stop(motion[stop]) && std::ranges::find(stops_, stop) == stops_.end()) {
      stops_.push_back(stop);
    }
  }
  has_height_ = options.height_range > 0;
  if (options.speeds) {
    const auto [low, high] = *options.speeds;
    const auto insert = std::ranges::find(motion, ActionKind::insert, &Action::kind);
    start_speed_ = std::clamp((insert->speed - low) / (high - low), 0.0, 1.0);
  }
}

PlanVariables::Values PlanVariables::start() const {
  Values values(size(), 0.0);
  if (options_.speeds) values.back() = start_speed_ * speed_scale;
  return values;
}

PlanVariables::Values PlanVariables::bounds(double sign) const {
  Values values(stops_.size(), sign * options_.depth_range / unit);
  if (has_height_) values.push_back(sign * options_.height_range / unit);
  if (options_.speeds) values.push_back(sign < 0 ? 0.0 : speed_scale);
  return values;
}

std::vector<std::string> PlanVariables::at_ends(const Values& values) const {
  const Values low = bounds(-1);
  const Values high = bounds(1);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < values.size(); ++i) {
    constexpr double close = 1e-6;  // of the range
    const double room = std::min(values[i] - low[i], high[i] - values[i]);
    if (room > close * (high[i] - low[i])) continue;
    if (i < stops_.size()) {
      names.push_back("the stop of motion." + std::to_string(stops_[i]) + " (--depth-range)");
    } else if (has_height_ && i == stops_.size()) {
      names.emplace_back("the height (--height-range)");
    } else {
      names.emplace_back("the speed (--speed-range)");
    }
  }
  return names;
}

void PlanVariables::apply(const Values& values, Scene& scene) const {
  auto& needle = scene.needles[needle_];
  for (std::size_t i = 0; i < stops_.size(); ++i) {
    Action& action = needle.motion[stops_[i]];
    if (action.position) *action.position += unit * values[i];
    if (action.depth) *action.depth -= unit * values[i];  // needles advance towards -x
  }
  if (has_height_) needle.height += unit * values[stops_.size()];
  if (!options_.speeds) return;
  const auto [low, high] = *options_.speeds;
  for (Action& action : needle.motion) {
    if (action.kind != ActionKind::insert) continue;
    const double old = action.speed;
    action.speed = low + values.back() / speed_scale * (high - low);
    if (&action == &needle.motion.front()) scene.time.step *= old / action.speed;
  }
}

}  // namespace stylet
