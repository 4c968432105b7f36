#include "stylet/simulation/hand.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/needle/advance.hpp"
#include "stylet/needle/axis.hpp"
#include "stylet/needle/stops.hpp"
#include "stylet/simulation/needle_path.hpp"
#include "stylet/simulation/point_text.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stylet {

namespace {

Motion clock(const Scene& scene) {
  if (!scene.needles.empty()) return Motion({});
  Action wait;
  wait.kind = ActionKind::hold;
  wait.duration = scene.time.duration;
  return Motion({wait});
}

}  // namespace

Schedule::Schedule(const Scene& scene, double extent)
    : needles_(scene.needles),
      until_implanted_(scene.time.until_implanted),
      duration_(scene.time.duration),
      extent_(extent),
      motion_(clock(scene)) {}

Wish Schedule::next() const {
  if (last_seed_left_) return {Wish::Kind::done};
  if (motion_.finished()) {
    if (n_entered_ == needles_.size()) return {Wish::Kind::done};
    return {Wish::Kind::enter, &needles_[n_entered_]};
  }
  const Action& action = motion_.action();
  if (action.kind == ActionKind::implant) return {Wish::Kind::implant, nullptr, action.target};
  return {};
}

void Schedule::entered(double skin, double at_rest) {
  const NeedleParameters& needle = needles_[n_entered_++];
  motion_ = Motion(needle.motion);
  motion_.enter(skin, Axis::along_sign);
  ++ended_;
  // The skin may have moved since the scene was checked.
  if (const auto fault = find_fault(needle.motion, Axis::along_sign, skin, true)) {
    throw NumericalError("needle '" + needle.name + "', motion." + std::to_string(fault->action) +
                         ": " + fault->reason + "; its entry point has moved by " +
                         brief(1e3 * (skin - at_rest)) + " mm along the needle before it enters");
  }
}

void Schedule::implanted() {
  last_seed_left_ = until_implanted_ && n_entered_ == needles_.size() && !motion_.will_implant();
  motion_.implanted();
  ++ended_;
}

void Schedule::stepped(const NeedleStep& step, const StepOutcome& outcome) {
  const std::size_t action = motion_.index();
  const Awaited awaited = motion_.awaits();
  const bool happened = (awaited == Awaited::withdrawal && outcome.withdrawn) ||
                        (awaited == Awaited::rest && comes_to_rest(outcome));
  motion_.taken(step, happened);
  if (motion_.index() != action) ++ended_;
  const double way_out = motion_.skin() - motion_.tip();
  if (awaited == Awaited::withdrawal && !happened && way_out > extent_) {
    throw NumericalError("needle '" + needles_[n_entered_ - 1].name +
                         "' does not come out: the tissue has followed it by " + brief(way_out) +
                         " m, more than its own length");
  }
}

bool Schedule::comes_to_rest(const StepOutcome& outcome) {
  if (outcome.conditions_change) settling_.restart();
  if (!settling_.is_settled(outcome.largest_speed, motion_.action().speed_tolerance)) return false;
  settling_.restart();
  return true;
}

void LiveHand::enter(NeedleParameters needle) {
  ++n_entered_;
  if (needle.name.empty()) needle.name = "needle" + std::to_string(n_entered_);
  needle.motion.clear();
  orders_.push_back({Wish::Kind::enter, std::move(needle)});
}

void LiveHand::move(double speed) {
  speed = std::clamp(speed, -most_, most_);
  if (speed != speed_) ++ended_;
  speed_ = speed;
}

void LiveHand::implant(std::string target) {
  orders_.push_back({Wish::Kind::implant, {}, std::move(target)});
}

void LiveHand::change(std::string key, double value) {
  orders_.push_back({Wish::Kind::change, {}, {}, std::move(key), value});
}

void LiveHand::limit_speed(double most) {
  most_ = most;
  move(speed_);
}

void LiveHand::hold_at(double tip) {
  orders_.clear();
  tip_ = tip;
  move(0);
}

void LiveHand::finish() {
  orders_.push_back({Wish::Kind::done});
}

Wish LiveHand::next() const {
  if (orders_.empty()) return {};
  const Ordered& first = orders_.front();
  return {first.kind, first.kind == Wish::Kind::enter ? &first.needle : nullptr, first.target,
          first.key, first.value};
}

NeedleStep LiveHand::step(double longest) {
  return {longest, tip_, tip_ + speed_ * longest};
}

void LiveHand::entered(double skin, double /*at_rest*/) {
  tip_ = skin;
  obeyed();
}

void LiveHand::implanted() {
  obeyed();
}

void LiveHand::changed() {
  obeyed();
}

void LiveHand::refused() {
  orders_.pop_front();
}

void LiveHand::obeyed() {
  orders_.pop_front();
  ++ended_;
}

void LiveHand::stepped(const NeedleStep& step, const StepOutcome& /*outcome*/) {
  tip_ = step.to;
}

double expected_time(const Scene& scene, const Mesh& mesh) {
  double total = scene.needles.empty() ? scene.time.duration : 0;
  if (scene.procedure) {
    for (const ProcedureRow& row : scene.procedure->rows) total += row.duration;
  }
  for (const auto& needle : scene.needles) {
    const double skin = skin_of(mesh, needle);
    const auto travels = travels_of(needle.motion, Axis::along_sign);
    for (std::size_t i = 0; i < travels.size(); ++i) {
      const Action& a = needle.motion[i];
      if (a.duration) total += *a.duration;
      if (a.speed <= 0) continue;
      total += std::abs(along_of(travels[i].to, skin) - along_of(travels[i].from, skin)) / a.speed;
    }
  }
  return total;
}

}  // namespace stylet
