#include "stylet/study/plan_variables.hpp"

#include "stylet/needle/embedded_track.hpp"

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
  const std::size_t in_space = stops_.size() > 1 ? 4 : 2;
  if (options.height_range > 0) n_across_ = scene.dim() == 2 ? 1 : in_space;
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
  values.resize(stops_.size() + n_across_, sign * options_.height_range / unit);
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
    } else if (i < stops_.size() + n_across_) {
      names.emplace_back(n_across_ == 1 ? "the height (--height-range)"
                                        : "the way across (--height-range)");
    } else {
      names.emplace_back("the speed (--speed-range)");
    }
  }
  return names;
}

void PlanVariables::shift(NeedleParameters& needle, const double* across) const {
  constexpr double in_front = 0.02;  // m, so that a shifted entry still lies before the skin
  SpaceParameters& space = needle.space;
  const ReferencePlace entry = space.entry->place();
  Vector3 way = space.target ? space.target->place() - entry : space.direction->vector();
  way = 1 / norm(way) * way;
  double deepest = 0;
  for (const Action& action : needle.motion) deepest = std::max(deepest, action.depth.value_or(0));
  const ReferencePlace end = space.target ? space.target->place() : entry + deepest * way;
  const auto [a, b] = across_of(way);
  const Vector3 all = unit * across[0] * a + unit * across[1] * b;
  const Vector3 far = n_across_ > 2 ? unit * across[2] * a + unit * across[3] * b : Vector3{};
  const auto given = [](ReferencePlace x) { return Components{x.x, x.y, x.z}; };
  space.entry = given(entry + all + -in_front * way);
  space.target = given(end + all + far);
  space.direction.reset();
}

void PlanVariables::apply(const Values& values, Scene& scene) const {
  auto& needle = scene.needles[needle_];
  for (std::size_t i = 0; i < stops_.size(); ++i) {
    Action& action = needle.motion[stops_[i]];
    if (action.position) *action.position += unit * values[i];
    if (action.depth) *action.depth -= unit * values[i];  // needles advance towards -x
  }
  if (n_across_ == 1) needle.height += unit * values[stops_.size()];
  if (n_across_ > 1) shift(needle, &values[stops_.size()]);
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
