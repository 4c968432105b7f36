#include "stylet/view/live_run.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/simulation/model.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

namespace stylet {

namespace {

constexpr double stand_off = 0.01;  // m in front of the skin, where a needle waits

// The fastest that the scene's own needles go (m/s).
double fastest(const Scene& scene) {
  double speed = 0;
  if (scene.procedure) {
    for (const auto& row : scene.procedure->rows) speed = std::max(speed, std::abs(row.speed));
  }
  for (const auto& needle : scene.needles) {
    for (const auto& action : needle.motion) speed = std::max(speed, action.speed);
  }
  return speed;
}

/// Made, as name-1, name-2 or so on.
std::string next_free(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code fault;
  if (const auto parent = fs::path(name).parent_path(); !parent.empty()) {
    fs::create_directories(parent, fault);
  }
  for (int number = 1;; ++number) {
    const std::string folder = name + "-" + std::to_string(number);
    if (fs::create_directory(folder, fault)) return folder;
    if (fault || !fs::exists(folder))
      throw IoError(folder + ": cannot be made: " + fault.message());
  }
}

}  // namespace

LiveRun::LiveRun(MPI_Comm comm, LiveOptions options) : comm_(comm), options_(std::move(options)) {
  load();
  begin(true);
  if (!options_.plan) return;
  planned_ = ways_of(options_.plan->load(), simulation_->mesh());
}

void LiveRun::load() {
  SceneSource source = options_.source;
  source.overrides.insert(source.overrides.end(), method_overrides_.begin(),
                          method_overrides_.end());
  std::string note;
  scene_ = with_procedure(comm_, source.load(), note);
  script_ = scene_.procedure ? scene_.procedure->rows : std::vector<ProcedureRow>();
  take_models();
  if (models_.empty()) {
    throw InputError(scene_.file + ": key 'needles': the scene has none; a hand needs one to hold");
  }
  log_.reset();
  folder_.clear();
}

void LiveRun::take_models() {
  changed_ = false;
  models_ = scene_.needles;
  for (const ProcedureRow& row : script_) {
    if (row.kind == ProcedureRow::Kind::enter) models_.push_back(row.needle);
  }
}

// The folder of a recording is made with it, so that none is left where a scene is refused.
void LiveRun::begin(bool records) {
  Scene live = for_live_hand(scene_);
  if (records && !options_.record.empty() && !log_) {
    folder_ = next_free(options_.record);
  }
  std::unique_ptr<LiveHand> hand;
  recording_ = nullptr;
  if (folder_.empty()) {
    hand = std::make_unique<LiveHand>();
  } else {
    if (!log_) log_ = std::make_unique<ProcedureLog>(scene_, folder_);
    auto recording = std::make_unique<RecordingHand>(*log_);
    recording_ = recording.get();
    recording_->record(records);
    hand = std::move(recording);
  }
  hand_ = hand.get();
  // A hand is quicker than the scene's steady advance, and may be slower.
  constexpr double margin = 2;
  constexpr double usual = 0.04;  // m/s
  const double speed = fastest(scene_);
  hand_->limit_speed(speed > 0 ? margin * speed : usual);
  simulation_ = std::make_unique<Simulation>(comm_, std::move(live), false, std::move(hand));
  height_ = models_.front().height;
  has_entered_ = false;
  approach_ = approach_of(*simulation_, next_needle());
  outside_ = approach_.skin - stand_off;
  wanted_ = Push{height_, 0};
  rows_ = script_;
  elapsed_ = 0;
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
  if (changed_ || !method_overrides_.empty()) return std::nullopt;
  const auto found = options_.bands.find(target);
  return found == options_.bands.end() ? std::nullopt : std::optional(found->second);
}

NeedleParameters LiveRun::next_needle() const {
  const auto model = std::min(static_cast<std::size_t>(n_entered_), models_.size() - 1);
  NeedleParameters needle = models_[model];
  needle.name = "needle" + std::to_string(n_entered_ + 1);
  needle.height = height_;
  needle.motion.clear();
  return needle;
}

void LiveRun::choose_height(double height) {
  if (in_tissue() || height == height_) return;
  if (has_entered_) {
    outside_ = tip();
    if (speed_ != 0) record(0.0);  // it stays behind
  }
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

void LiveRun::want(const std::variant<Aim, Push>& wanted) {
  wanted_ = wanted;
  rows_.clear();
}

void LiveRun::enter() {
  record(next_needle());
  ++n_entered_;
  has_entered_ = true;
}

// What the recording did before this step. Its rows end where steps of the clock do.
void LiveRun::follow() {
  while (!rows_.empty()) {
    const ProcedureRow row = rows_.front();
    if (row.kind == ProcedureRow::Kind::move && elapsed_ + 0.5 * step_length() < row.duration) {
      if (row.speed != speed_) record(row.speed);
      elapsed_ += step_length();
      return;
    }
    rows_.erase(rows_.begin());
    elapsed_ = 0;
    if (row.kind == ProcedureRow::Kind::enter) {
      choose_height(row.needle.height);
      ++n_entered_;
      has_entered_ = true;
      record(row.needle);
    }
    if (row.kind == ProcedureRow::Kind::implant) record(SeedFor{row.target});
    if (row.kind == ProcedureRow::Kind::change) change(row.key, row.value);
  }
  wanted_ = Push{height_, 0};
  tell("the recorded procedure is at its end");
}

void LiveRun::guide() {
  if (!rows_.empty()) {
    follow();
    return;
  }
  const auto* aim = std::get_if<Aim>(&wanted_);
  const auto* push = std::get_if<Push>(&wanted_);
  choose_height(aim != nullptr ? aim->height : push->height);
  const double h = step_length();
  const double from = has_entered_ ? tip() : outside_;
  double speed = push != nullptr ? push->speed : (aim->tip - from) / h;
  speed = std::clamp(speed, -speed_limit(), speed_limit());
  if (speed > 0 && from + speed * h > approach_.deepest && approach_.obstacle.empty()) {
    speed = std::max(0.0, (approach_.deepest - from) / h);
    tell("the far side of the tissue is near: no further");
  }
  if (!has_entered_) {
    // No further out than the hand can see.
    const double to = std::max(from + speed * h, approach_.skin - 2 * stand_off);
    outside_ = std::min(to, approach_.skin);
    if (to <= approach_.skin) return;
    speed = (to - approach_.skin) / h;  // the way to the skin is behind it
    if (!approach_.obstacle.empty()) {
      tell(approach_.obstacle);
      return;
    }
    enter();
  }
  if (speed != speed_) record(speed);
}

void LiveRun::record(Act act) {
  Done done{n_steps_, std::move(act)};
  if (recording_ != nullptr && is_mark(done)) done.mark = recording_->mark();
  obey(done.act);
  done_.push_back(std::move(done));
}

void LiveRun::obey(const Act& act) {
  if (const auto* needle = std::get_if<NeedleParameters>(&act)) {
    hand_->enter(*needle);
  } else if (const auto* seed = std::get_if<SeedFor>(&act)) {
    hand_->implant(seed->target);
  } else if (const auto* change = std::get_if<Change>(&act)) {
    simulation_->change(change->key, change->value);
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
  constexpr double readable = 5;  // s
  if ((n_steps_ - notice_at_) * step_length() > readable) notice_.clear();
  guide();
  advance();
}

void LiveRun::tell(std::string notice) {
  notice_ = std::move(notice);
  notice_at_ = n_steps_;
}

}  // namespace stylet
