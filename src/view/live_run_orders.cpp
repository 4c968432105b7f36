// What is done between the steps of a LiveRun: seeds, changes, undo.
#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/solvers/modes.hpp"
#include "stylet/view/live_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <utility>

namespace stylet {

// Of those without a seed, or of all where each has one.
std::string LiveRun::nearest_target() const {
  const Scene& scene = simulation_->scene();
  const auto& seeds = simulation_->seeds();
  const WorldPoint tip = Axis{height_}.at<WorldFrame>(this->tip());
  const auto key = [&](const Target& target) {
    const bool taken = std::ranges::find(seeds, target.name, &Seed::target) != seeds.end();
    return std::pair(taken, norm(Vector2{tip.x - target.point.x, tip.y - target.point.y}));
  };
  const auto nearest = std::ranges::min_element(scene.targets, {}, key);
  return nearest == scene.targets.end() ? std::string() : nearest->name;
}

void LiveRun::seed(const std::string& target) {
  const std::string why =
      in_tissue() ? simulation_->why_no_seed() : "the needle is outside: no seed can be left";
  tell(why);
  if (why.empty()) record(SeedFor{target.empty() ? nearest_target() : target});
}

void LiveRun::choose_method(const std::string& method) {
  const auto before = method_overrides_;
  method_overrides_ = {"time.method=" + method};
  std::string damping;
  const RayleighDamping damped = options_.source.load().tissue.damping.value_or(RayleighDamping{});
  if (method == "explicit" && damped.stiffness_factor > 0) {
    // The lowest mode of vibration is damped as it was; higher ones less.
    std::vector<int> held;
    for (const auto& dof : simulation_->body().held()) held.push_back(dof.dof);
    const double omega = natural_frequencies(simulation_->tissue(), held, 1).at(0);
    const double mass_factor = damped.mass_factor + damped.stiffness_factor * omega * omega;
    method_overrides_.emplace_back("tissue.damping.stiffness_factor=null");
    method_overrides_.push_back("tissue.damping.mass_factor=" + exact(mass_factor) + " 1/s");
    char text[160];
    std::snprintf(text, sizeof text,
                  "; damped by mass (%.3g 1/s) instead of stiffness, which explicit steps cannot "
                  "bear: the lowest mode as before",
                  mass_factor);
    damping = text;
  }
  std::string refused;
  try {
    load();
    begin(true);
  } catch (const InputError& error) {
    refused = error.what();
    method_overrides_ = before;
    load();
    begin(true);
  }
  tell(refused.empty() ? "anew, " + method + damping : refused);
}

void LiveRun::change(const std::string& key, double value) {
  notice_.clear();
  const bool of_needle = key.starts_with("needle.");
  try {
    auto models = models_;  // all of them change, or none
    if (of_needle) {
      for (auto& model : models) stylet::change(simulation_->scene(), model, key, value);
    }
    if (!of_needle || has_entered_) record(Change{key, value});
    models_ = std::move(models);
  } catch (const InputError& error) {
    tell(error.what());
    return;
  }
  if (key == "hand.speed_limit") return;
  changed_ = true;
  if (!log_ || (of_needle && !has_entered_)) return;
  ProcedureRow row{ProcedureRow::Kind::change};
  row.key = key;
  row.value = value;
  log_->event(row);
}

std::vector<Changeable> LiveRun::parameters() const {
  auto numbers = changeable(*simulation_);
  if (has_entered_) return numbers;
  std::erase_if(numbers,
                [](const Changeable& number) { return number.key.starts_with("needle."); });
  auto of_next = changeable(next_needle());
  numbers.insert(numbers.begin(), of_next.begin(), of_next.end());
  return numbers;
}

bool LiveRun::is_mark(const Done& done) {
  return std::holds_alternative<NeedleParameters>(done.act) ||
         std::holds_alternative<SeedFor>(done.act);
}

bool LiveRun::can_undo() const {
  return std::ranges::any_of(done_, is_mark);
}

bool LiveRun::undo() {
  const auto last = std::find_if(done_.rbegin(), done_.rend(), is_mark);
  if (last == done_.rend()) return false;
  const bool was_seed = std::holds_alternative<SeedFor>(last->act);
  const long steps = last->step;
  const std::size_t mark = last->mark;
  const std::vector<Done> done(done_.begin(), std::prev(last.base()));
  const double height = height_;
  begin(false);
  rows_.clear();
  for (const Done& earlier : done) {
    while (n_steps_ < earlier.step) advance();
    if (const auto* needle = std::get_if<NeedleParameters>(&earlier.act)) {
      height_ = needle->height;
      approach_ = approach_of(*simulation_, *needle);
      ++n_entered_;
      has_entered_ = true;
    }
    obey(earlier.act);
    done_.push_back(earlier);
  }
  while (n_steps_ < steps) advance();
  if (recording_ != nullptr) {
    recording_->record(true);
    recording_->undo(mark);
  }
  choose_height(height);
  wanted_ = Push{height_, 0};
  tell(was_seed ? "the last seed is undone" : "the last needle is undone");
  return true;
}

void LiveRun::restart() {
  take_models();
  begin(true);
  if (recording_ != nullptr) recording_->undo(0);
  tell("anew");
}

Score LiveRun::finish() {
  Score score = score_of(*simulation_);
  if (log_) {
    log_->flush();
    const std::string path = folder_ + "/score.json";
    std::ofstream out(path);
    out << json_of(score).dump(2) << '\n';
    if (!out.flush()) throw IoError(path + ": cannot be written");
  }
  return score;
}

}  // namespace stylet
