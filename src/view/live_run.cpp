#include "stylet/view/live_run.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/simulation/procedure_log.hpp"
#include "stylet/solvers/modes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace stylet {

namespace {

constexpr double stand_off = 0.01;  // m in front of the skin, where a needle waits

// The fastest that the scene's own needles go (m/s).
double fastest(const Scene& scene) {
  double speed = 0;
  for (const auto& needle : scene.needles) {
    for (const auto& action : needle.motion) speed = std::max(speed, action.speed);
  }
  return speed;
}

}  // namespace

LiveRun::LiveRun(MPI_Comm comm, SceneSource source, std::map<std::string, double> bands)
    : comm_(comm), source_(std::move(source)), bands_(std::move(bands)) {
  build();
  // A hand is quicker than the scene's steady advance, and may be slower.
  constexpr double margin = 2;
  speed_limit_ = margin * fastest(scene_);
}

void LiveRun::build() {
  SceneSource source = source_;
  source.overrides.insert(source.overrides.end(), method_overrides_.begin(),
                          method_overrides_.end());
  scene_ = source.load();
  if (scene_.needles.empty()) {
    throw InputError(scene_.file + ": key 'needles': the scene has none; a hand needs one to hold");
  }
  Scene live = for_live_hand(scene_);
  constexpr double long_time = 60;  // s; the strain is looked at in shares of it
  live.time.duration = long_time;
  auto hand = std::make_unique<LiveHand>();
  hand_ = hand.get();
  simulation_ = std::make_unique<Simulation>(comm_, std::move(live), false, std::move(hand));
  height_ = scene_.needles.front().height;
  has_entered_ = false;
  approach_ = approach_of(*simulation_, next_needle());
  outside_ = approach_.skin - stand_off;
  wanted_ = Push{height_, 0};
  speed_ = 0;
  n_entered_ = 0;
  n_steps_ = 0;
  done_.clear();
  last_ = {};
  trace_ = {};
  ++epoch_;
}

std::string LiveRun::method() const {
  switch (scene_.time.method) {
    case TimeMethod::explicit_newmark:
      return "explicit";
    case TimeMethod::quasi_static:
      return "quasi_static";
    case TimeMethod::implicit_newmark:
      break;
  }
  return "implicit";
}

bool LiveRun::in_tissue() const {
  return has_entered_ && simulation_->needle() != nullptr && !simulation_->needle()->released();
}

double LiveRun::tip() const {
  return has_entered_ && simulation_->needle() != nullptr ? simulation_->needle()->tip() : outside_;
}

std::optional<double> LiveRun::band(const std::string& target) const {
  const auto found = bands_.find(target);
  return found == bands_.end() ? std::nullopt : std::optional(found->second);
}

NeedleParameters LiveRun::next_needle() const {
  const auto model = std::min(static_cast<std::size_t>(n_entered_), scene_.needles.size() - 1);
  NeedleParameters needle = scene_.needles[model];
  needle.name = "needle" + std::to_string(n_entered_ + 1);
  needle.height = height_;
  needle.motion.clear();
  return needle;
}

void LiveRun::choose_height(double height) {
  if (in_tissue() || height == height_) return;
  if (has_entered_) outside_ = tip();
  has_entered_ = false;
  height_ = height;
  Approach approach = approach_of(*simulation_, next_needle());
  // In front of what it cannot enter a needle stops where it did on its last height.
  if (approach.obstacle.empty()) {
    approach_ = std::move(approach);
  } else {
    approach_.obstacle = std::move(approach.obstacle);
  }
  outside_ = std::min(outside_, approach_.skin);
}

void LiveRun::enter() {
  record(next_needle());
  ++n_entered_;
  has_entered_ = true;
}

void LiveRun::guide() {
  const auto* aim = std::get_if<Aim>(&wanted_);
  const auto* push = std::get_if<Push>(&wanted_);
  choose_height(aim != nullptr ? aim->height : push->height);
  const double h = step_length();
  const double from = has_entered_ ? tip() : outside_;
  double speed = push != nullptr ? push->speed : (aim->tip - from) / h;
  speed = std::clamp(speed, -speed_limit_, speed_limit_);
  if (speed > 0 && from + speed * h > approach_.deepest && approach_.obstacle.empty()) {
    speed = std::max(0.0, (approach_.deepest - from) / h);
    notice_ = "the far side of the tissue is near: no further";
  }
  if (!has_entered_) {
    // No further out than the hand can see.
    const double to = std::max(from + speed * h, approach_.skin - 2 * stand_off);
    outside_ = std::min(to, approach_.skin);
    if (to <= approach_.skin) return;
    speed = (to - approach_.skin) / h;  // the way to the skin is behind it
    if (!approach_.obstacle.empty()) {
      notice_ = approach_.obstacle;
      return;
    }
    enter();
  }
  if (speed != speed_) record(speed);
}

void LiveRun::record(Act act) {
  obey(act);
  done_.push_back({n_steps_, std::move(act)});
}

void LiveRun::obey(const Act& act) {
  if (const auto* needle = std::get_if<NeedleParameters>(&act)) {
    hand_->enter(*needle);
  } else if (const auto* seed = std::get_if<SeedFor>(&act)) {
    hand_->implant(seed->target);
  } else if (const auto* change = std::get_if<Change>(&act)) {
    hand_->change(change->key, change->value);
  } else {
    speed_ = std::get<double>(act);
    hand_->move(speed_);
  }
}

void LiveRun::advance() {
  last_ = simulation_->step();
  ++n_steps_;
  const Energies& e = simulation_->energies();
  const NeedleForces& forces = last_.needle.forces;
  trace_.add({last_.t, forces.tip, forces.friction, e.kinetic, e.strain, e.dissipated, e.external});
}

void LiveRun::step() {
  guide();
  advance();
}

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
  notice_ = why;
  if (why.empty()) record(SeedFor{target.empty() ? nearest_target() : target});
}

void LiveRun::choose_method(const std::string& method) {
  const auto before = method_overrides_;
  method_overrides_ = {"time.method=" + method};
  std::string damping;
  const RayleighDamping damped = source_.load().tissue.damping.value_or(RayleighDamping{});
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
  try {
    build();
    notice_ = "anew, " + method + damping;
  } catch (const InputError& error) {
    method_overrides_ = before;
    build();
    notice_ = error.what();
  }
}

void LiveRun::change(const std::string& key, double value) {
  bands_.clear();  // of the scene as it was
  record(Change{key, value});
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
  std::vector<Done> done(done_.begin(), std::prev(last.base()));
  const double height = height_;
  build();
  for (auto& [step, act] : done) {
    while (n_steps_ < step) advance();
    if (const auto* needle = std::get_if<NeedleParameters>(&act)) {
      height_ = needle->height;
      approach_ = approach_of(*simulation_, *needle);
      ++n_entered_;
      has_entered_ = true;
    }
    record(std::move(act));
  }
  while (n_steps_ < steps) advance();
  choose_height(height);
  wanted_ = Push{height_, 0};
  notice_ = was_seed ? "the last seed is undone" : "the last needle is undone";
  return true;
}

void LiveRun::restart() {
  build();
  notice_ = "anew";
}

}  // namespace stylet
