#include "stylet/simulation/simulation.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/base/text.hpp"
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/dynamics/quasi_static.hpp"
#include "stylet/geometry/rotation.hpp"
#include "stylet/geometry/triangle.hpp"
#include "stylet/needle/stops.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/simulation/needle_path.hpp"
#include "stylet/simulation/point_text.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stylet {

namespace {

// Solves of one step: contact changes, secant steps and hand-overs. Beyond it the contact cycles.
constexpr int most_passes = 500;
// Triangles below `wanted_quality` are repaired by flips after a hand-over; below the floor the run
// ends.
constexpr double wanted_quality = 0.2;
constexpr double quality_floor = 0.02;

Multiplier multiplier(const Trial& trial) {
  return {trial.needed.lambda, trial.working.lambda, trial.settled.lambda, trial.means};
}

double estimated_time(const Scene& scene, const Mesh& mesh) {
  double total = scene.needles.empty() ? scene.time.duration : 0;
  for (const auto& needle : scene.needles) {
    const double skin = Axis::along(find_entry(mesh, {needle.height}, needle.name).x);
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

std::vector<EmbeddedPoint> embed(const Mesh& mesh,
                                 std::span<const ReferencePoint> points,
                                 const Rotation& rotation) {
  std::vector<EmbeddedPoint> embedded;
  int hint = 0;
  for (const auto& x : points) {
    const auto found = locate(mesh, x, hint);
    if (!found) {
      const auto written = rotation.to_scene(x);
      throw InputError("a vertex of the membrane lies outside the tissue: (" +
                       ten_digits(written.x) + ", " + ten_digits(written.y) + ") m");
    }
    embedded.push_back(*found);
    hint = found->cell;
  }
  return embedded;
}

}  // namespace

Simulation::Simulation(MPI_Comm comm, Scene scene, bool track_energy)
    : scene_(in_needle_frame(std::move(scene))),
      numbered_(make_mesh(comm, scene_)),
      conditions_(
          [this]() -> const Scene& {
            check_against_mesh(scene_, numbered_.mesh);
            return scene_;
          }(),
          numbered_.mesh),
      tissue_(make_tissue(comm, scene_, numbered_)),
      ledger_(*tissue_, mesh(), scene_.time, scene_.tissue.thickness),
      track_energy_(track_energy) {
  if (scene_.time.method == TimeMethod::explicit_newmark) {
    integrator_ = std::make_unique<ExplicitNewmark>(*tissue_, mesh(), scene_.time);
    counts_.stable_step = integrator_->stable_step();
  } else {
    if (scene_.time.method == TimeMethod::quasi_static) {
      integrator_ = std::make_unique<QuasiStatic>(*tissue_, mesh());
    } else {
      integrator_ = std::make_unique<ImplicitNewmark>(*tissue_, mesh(), scene_.time);
    }
  }
  base_ = conditions_.prescribed(0);
  if (scene_.time.method == TimeMethod::quasi_static || !scene_.needles.empty()) {
    check_held(scene_, mesh(), base_);
  }
  check_needles(scene_, mesh(), conditions_);
  check_step(scene_, mesh(), std::min(scene_.time.step, integrator_->stable_step()));
  for (OwnedVec* vec : {&state_.u, &state_.v, &state_.a, &load_}) {
    *vec = tissue_->make_vector();
    check(VecSet(vec->get(), 0));
  }
  if (conditions_.has_load()) {
    last_load_ = tissue_->make_vector();
    check(VecSet(last_load_.get(), 0));
  }
  if (!scene_.prescribed.empty()) {
    reaction_ = tissue_->make_vector();
    check(VecSet(reaction_.get(), 0));
  }
  if (scene_.membrane) {
    auto& polygon = scene_.membrane->polygon;
    if (polygon.empty()) polygon = region_outline(mesh(), scene_.membrane->region);
    membrane_ = embed(mesh(), polygon, Rotation(scene_.needle_angle));
  }
  for (const auto& probe : scene_.probes) probes_.push_back(*locate(mesh(), probe.point));
  if (scene_.needles.empty()) {
    Action wait;
    wait.kind = ActionKind::hold;
    wait.duration = scene_.time.duration;
    clock_.emplace(std::vector<Action>{wait});
  }
  std::vector<int> all(static_cast<std::size_t>(mesh().n_cells()));
  std::iota(all.begin(), all.end(), 0);
  counts_.worst_quality = mesh().worst_quality(all);
  double first = Axis::along(mesh().point(0));
  double last = first;
  for (int node = 0; node < mesh().n_nodes(); ++node) {
    first = std::min(first, Axis::along(mesh().point(node)));
    last = std::max(last, Axis::along(mesh().point(node)));
  }
  extent_ = last - first;
  estimated_time_ = estimated_time(scene_, mesh());
}

void Simulation::start() {
  started_ = true;
  update_load(0);
  // Quasi-static loads grow from zero in the first step; dynamic ones act at once.
  if (scene_.time.method != TimeMethod::quasi_static) {
    if (last_load_) check(VecCopy(load_.get(), last_load_.get()));
    initial_acceleration(*tissue_, state_, load_.get(), constraints());
  }
}

void Simulation::update_load(double t) {
  if (!conditions_.has_load()) return;
  load_changed_ = true;
  load_time_ = t;
  const auto force = conditions_.load(mesh(), t);
  PetscScalar* values = nullptr;
  check(VecGetArray(load_.get(), &values));
  std::copy(force.begin() + tissue_->first_dof(), force.begin() + tissue_->end_dof(), values);
  check(VecRestoreArray(load_.get(), &values));
}

StepRecord Simulation::step() {
  try {
    return step_unguarded();
  } catch (const NumericalError& error) {
    throw NumericalError("at t = " + exact(state_.t) + " s: " + error.what());
  }
}

StepRecord Simulation::step_unguarded() {
  if (!started_) start();
  StepRecord record;
  act_without_time();
  const Needle* needle = this->needle();
  const std::size_t action = done_ ? 0 : motion().index();
  const double wanted = scene_.time.step;
  double longest = std::min(wanted, integrator_->stable_step());
  // Sub-steps need not fill the step exactly: the nearest whole number of them does.
  while (!done_ && needle == this->needle() && motion().index() == action &&
         record.h + 0.5 * longest < wanted) {
    longest = std::min(wanted, integrator_->stable_step());
    record.h += sub_step(longest, record);
    ++record.sub_steps;
    counts_.peak_needle_force =
        std::max(counts_.peak_needle_force, std::abs(record.needle.forces.total()));
    if (motion().finished()) break;
  }
  act_without_time();
  if (done_ || needle != this->needle() || motion().index() != action || state_.t >= next_strain_) {
    watch_strain();
  }
  if (done_ && ledger_.unchecked()) {
    ledger_.weigh(integrator_->energy(state_), *tissue_, state_);
  } else if (track_energy_ && ledger_.unchecked()) {
    ledger_.measure(integrator_->energy(state_), *tissue_, state_);
  }
  record.t = state_.t;
  if (record.sub_steps > 0) ++counts_.steps;
  counts_.sub_steps += record.sub_steps;
  counts_.passes += record.passes;
  counts_.iterations += record.iterations;
  return record;
}

// At evenly spaced moments and at the end of every action: a look at all triangles costs about as much
// as a whole step.
void Simulation::watch_strain() {
  constexpr double moments = 32;
  next_strain_ = state_.t + estimated_time_ / moments;
  integrator_->complete();
  const auto u = gather_all(state_.u.get());
  const bool is_in = needle_ && !needle_->track().empty();
  raise(largest_strain_, mesh(), u, state_.t, is_in ? &needle_->track() : nullptr,
        is_in ? needle_->parameters().cutting.tip_length : 0);
}

// Enters needles, implants seeds, and ends the run.
void Simulation::act_without_time() {
  while (!done_) {
    if (clock_) {
      done_ = clock_->finished();
      return;
    }
    if (!needle_ || needle_->motion().finished()) {
      if (n_entered_ == scene_.needles.size()) {
        done_ = true;
        return;
      }
      enter_next_needle();
    }
    if (needle_->motion().finished()) continue;
    if (needle_->motion().is_no_motion()) {
      needle_->motion().finish_action();
      continue;
    }
    if (needle_->motion().action().kind != ActionKind::implant) return;
    implant();
  }
}

void Simulation::enter_next_needle() {
  EarlierCuts earlier;
  if (needle_) {
    earlier_needles_ = counts_.needle;
    earlier = needle_->leave(mesh());
  }
  const auto& parameters = scene_.needles[n_entered_++];
  NeedleTissue tissue;
  if (scene_.membrane) {
    tissue.membrane = scene_.membrane->polygon;
    tissue.puncture_force = scene_.membrane->puncture_force;
  }
  tissue.earlier = std::move(earlier);
  tissue.region_modulus.resize(mesh().data().region_names.size());
  for (const auto& region : scene_.tissue.regions) {
    tissue.region_modulus[static_cast<std::size_t>(mesh().region_index(region.region))] =
        region.material.youngs_modulus;
  }
  needle_.emplace(parameters, std::move(tissue), integrator_->decides_by_velocity());
  const Entry entry = find_entry(mesh(), needle_->axis(), parameters.name);
  std::vector<int> nodes{entry.node, entry.neighbour};
  std::ranges::sort(nodes);
  apply(needle_->enter(mesh(), entry, start_view(nodes)), true);
  largest_tip_force_ = 0;
  // The skin may have moved since the scene was checked.
  const double skin = needle_->motion().skin();
  if (const auto fault = find_fault(parameters.motion, Axis::along_sign, skin, true)) {
    throw NumericalError(
        "needle '" + parameters.name + "', motion." + std::to_string(fault->action) + ": " +
        fault->reason + "; its entry point has moved by " +
        brief(1e3 * (skin - Axis::along(entry.x))) + " mm along the needle before it enters");
  }
}

// A seed is where a needle left it that had cut its way there.
void Simulation::require_cut_in() const {
  const auto& needle = *needle_;
  const double path = needle.track().distances(mesh()).front();
  const double depth = needle.motion().tip() - needle.motion().skin();
  const std::string who = "needle '" + needle.parameters().name + "' ";
  if (needle.released()) {
    throw NumericalError(who + "implants a seed, but its tip is not in the tissue: it stands " +
                         brief(-1e3 * depth) + " mm in front of the skin's place at entry");
  }
  const bool beyond = needle.tip_contact() != TipContact::open && depth >= path;
  if (needle.track().size() == 2 && !beyond) {
    throw NumericalError(who + "implants a seed " + brief(1e3 * depth) +
                         " mm behind the skin, within its first cut, which goes " +
                         brief(1e3 * path) +
                         " mm at once, half-way through an element: only a finer mesh can tell how "
                         "far it has cut");
  }
  // Part of the tip is in a shallow wound by right, but not in one that is a mere dent in the skin.
  constexpr double dent = 0.2;
  const double needed = needle.force_to_cut(mesh());
  const bool is_in = path >= needle.parameters().cutting.tip_length || path >= dent * depth;
  if (needle.track().size() > 1 && is_in) return;
  throw NumericalError(who + "implants a seed, but has not cut its way in: its tip force reached " +
                       brief(largest_tip_force_) + " N of the " + brief(needed) +
                       " N that are needed, and its tip is " + brief(1e3 * path) +
                       " mm in the tissue after " + brief(1e3 * depth) +
                       " mm of insertion; a smaller cutting_force or puncture_force, or a deeper "
                       "insert");
}

void Simulation::implant() {
  require_cut_in();
  Motion& motion = needle_->motion();
  Seed seed;
  seed.needle = needle_->parameters().name;
  seed.target = motion.action().target;
  if (seed.target.empty() && scene_.targets.size() == 1) seed.target = scene_.targets[0].name;
  seed.time = state_.t;
  const ReferencePoint p = needle_->tip_point(mesh());
  const auto place = locate(mesh(), p, mesh().cells_around(needle_->track().tip()).front());
  if (!place) throw NumericalError("a seed fell outside the tissue");
  seed.place = *place;
  const WorldPoint tip = needle_->axis().at<WorldFrame>(motion.tip());
  seed.displacement = {tip.x - p.x, tip.y - p.y};
  seed.tip = needle_->stand(mesh());
  seeds_.push_back(seed);
  motion.finish_action();
  if (!scene_.time.until_implanted || n_entered_ < scene_.needles.size()) return;
  const auto& actions = needle_->parameters().motion;
  done_ = std::none_of(actions.begin() + static_cast<std::ptrdiff_t>(motion.index()), actions.end(),
                       [](const Action& a) { return a.kind == ActionKind::implant; });
}

ConstraintSet Simulation::constraints() const {
  ConstraintSet set = needle_constraints(needle_ && !needle_->released() ? &*needle_ : nullptr);
  set.dofs.insert(set.dofs.end(), base_.begin(), base_.end());
  return set;
}

ConstraintSet Simulation::needle_constraints(const Needle* active) const {
  ConstraintSet set;
  if (active != nullptr) set = active->constraints(mesh());
  // Where a support and the needle meet, the support holds.
  std::erase_if(set.dofs, [&](const PrescribedDof& c) {
    return std::ranges::binary_search(base_, c.dof, {}, &PrescribedDof::dof);
  });
  return set;
}

double Simulation::sub_step(double longest, StepRecord& record) {
  NeedleStep step = motion().next(longest);
  const bool load_changes = conditions_.load_changes(state_.t, state_.t + step.h);
  const auto begin = [&] {
    const double t1 = state_.t + step.h;
    if (load_changes) update_load(t1);
    if (!scene_.prescribed.empty()) base_ = conditions_.prescribed(t1);
    integrator_->begin(state_, load_.get(), step.h, base_);
  };
  Needle* active = nullptr;
  if (needle_ && (!needle_->released() || motion().action().kind == ActionKind::insert)) {
    active = &*needle_;
    active->start_step(mesh(), step);
  }
  const bool ends_withdrawn = needle_ && motion().action().kind == ActionKind::retract &&
                              !motion().action().depth && !motion().action().position;
  const bool ends_settled =
      motion().action().kind == ActionKind::settle && !motion().action().duration;
  const std::size_t action = motion().index();

  begin();
  NeedleStepReport report;
  Trial trial;
  std::vector<int> shaft;
  for (int pass = 0;; ++pass) {
    const bool edited = active != nullptr && edit_for_needle();
    // The elements that the edit left bound the very step that it belongs to.
    if (const double stable = integrator_->stable_step(); edited && stable < step.h) {
      step = motion().next(stable);
      active->shorten_step(step);
      begin();
    }
    if (active != nullptr) {
      shaft = active->loaded_nodes(mesh());
      integrator_->watch(shaft);
    }
    ConstraintSet set = needle_constraints(active);
    set.load_jumps = load_changes;
    trial = integrator_->attempt(set, edited);
    ++record.passes;
    record.iterations += trial.iterations;
    if (active == nullptr ||
        active->review(mesh(), trial_view(shaft, trial, step.h), multiplier(trial)))
      break;
    if (pass == most_passes) {
      throw NumericalError("the contact of needle '" + active->parameters().name +
                           "' does not settle after " + std::to_string(pass) +
                           " solves; take a smaller time.step");
    }
  }
  trial = integrator_->finish(active == nullptr || conditions_.has_load() ||
                              !scene_.prescribed.empty() || ends_settled);
  if (active != nullptr) {
    report = active->commit(mesh(), start_view(shaft), trial_view(shaft, trial, step.h),
                            multiplier(trial), ledger_.end_weight(trial));
  }
  accept(trial, step.h, report);
  largest_tip_force_ = std::max(largest_tip_force_, report.forces.tip);
  if (active != nullptr) {
    count_deformed_inversions();
    counts_.needle = earlier_needles_;
    counts_.needle.hand_overs += active->counts().hand_overs;
    counts_.needle.fallbacks += active->counts().fallbacks;
    counts_.needle.punctures += active->counts().punctures;
  } else {
    motion().commit(step);
  }
  record.needle = report;
  if (scene_.time.method == TimeMethod::explicit_newmark) {
    counts_.stable_step = std::min(counts_.stable_step, integrator_->stable_step());
  }
  const bool same_action = !motion().finished() && motion().index() == action;
  if (same_action && (ends_withdrawn || ends_settled)) end_open_action(state_.t - step.h);
  return step.h;
}

// Actions that end when something has happened, which it may never do. t0: start of the step (s).
void Simulation::end_open_action(double t0) {
  Motion& motion = this->motion();
  if (motion.action().kind == ActionKind::retract) {
    if (needle_->released()) {
      motion.finish_action();
    } else if (motion.skin() - motion.tip() > extent_) {
      throw NumericalError("needle '" + needle_->parameters().name +
                           "' does not come out: the tissue has followed it by " +
                           brief(motion.skin() - motion.tip()) + " m, more than its own length");
    }
    return;
  }
  PetscReal speed = 0;
  check(VecNorm(state_.v.get(), NORM_INFINITY, &speed));
  if (conditions_.changes(t0, state_.t)) settling_.restart();
  if (!settling_.is_settled(speed, motion.action().speed_tolerance)) return;
  motion.finish_action();
  settling_.restart();
}

// Work of the forces on prescribed curves in a step that is about to be accepted (J).
double Simulation::prescribed_work(const Trial& trial) const {
  double work = 0;
  const double end = ledger_.end_weight(trial);
  for (std::size_t i = 0; i < scene_.prescribed.size(); ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      const Vec vectors[4] = {reaction_.get(), trial.working.reaction, state_.u.get(), trial.u};
      const auto values = gather(vectors, conditions_.curve_dofs(i, k));
      for (std::size_t n = 0; n < values[0].size(); ++n) {
        work += ((1 - end) * values[0][n] + end * values[1][n]) * (values[3][n] - values[2][n]);
      }
    }
  }
  return work;
}

void Simulation::accept(const Trial& trial, double h, const NeedleStepReport& report) {
  const double external = report.work + trial.blow_work + (reaction_ ? prescribed_work(trial) : 0);
  const Vec load0 = load_changed_ ? last_load_.get() : nullptr;
  ledger_.add(*tissue_, state_, trial, h, load0, last_load_ ? load_.get() : nullptr, external,
              report.dissipated);
  if (reaction_) check(VecCopy(trial.settled.reaction, reaction_.get()));
  integrator_->accept();
  if (load_changed_) check(VecCopy(load_.get(), last_load_.get()));
  load_changed_ = false;
  if (ledger_.due()) ledger_.weigh(integrator_->energy(state_), *tissue_, state_);
}

bool Simulation::edit_for_needle() {
  bool edited = false;
  while (needle_->wants_edit()) {
    const auto nodes = needle_->watched(mesh());
    const NeedleEdits edits = needle_->plan(mesh(), start_view(nodes));
    if (edits.empty()) continue;
    apply(edits, false);
    edited = true;
  }
  return edited;
}

void Simulation::apply(const NeedleEdits& edits, bool repair) {
  static const LogEvent event("StyletEdit");
  const LogScope scope(event);
  Mesh& mesh = numbered_.mesh;
  std::vector<int> touched;
  for (const auto& move : edits.moves) {
    mesh.move_node(move.node, move.x);
    const auto around = mesh.cells_around(move.node);
    touched.insert(touched.end(), around.begin(), around.end());
  }
  const auto flip = [&](const EdgeFlip& edge) {
    const auto both = mesh.cells_with(edge.a, edge.b);
    mesh.flip_edge(edge.a, edge.b);
    touched.insert(touched.end(), both.begin(), both.end());
    ++counts_.edge_flips;
  };
  for (const auto& edge : edits.flips) flip(edge);
  if (repair) {
    counts_.edge_flips +=
        static_cast<int>(stylet::repair(mesh, needle_->track(), touched, wanted_quality).size());
  }
  sort_unique(touched);
  const double worst = mesh.worst_quality(touched);
  counts_.worst_quality = std::min(counts_.worst_quality, worst);
  if (worst < quality_floor) {
    throw NumericalError("needle '" + needle_->parameters().name +
                         "' would leave an element of quality " + std::to_string(worst) +
                         " (at least " + std::to_string(quality_floor) +
                         " is needed); refine the mesh or move the needle");
  }
  const auto rows = tissue_->rows_of(mesh, touched);
  integrator_->complete_at(rows);
  const double before = ledger_.within(*tissue_, rows, state_);
  for (const auto& move : edits.moves) {
    const auto set = [&](Vec vector, Vector2 value) {
      set_owned(vector, 2 * move.node, value.x);
      set_owned(vector, 2 * move.node + 1, value.y);
    };
    set(state_.u.get(), move.state.u);
    set(state_.v.get(), move.state.v);
    set(state_.a.get(), move.state.a);
  }
  if (tissue_->update(mesh, touched)) ++counts_.pattern_rebuilds;
  if (conditions_.has_body_force()) update_load(load_time_);
  integrator_->touched(mesh, touched);
  ledger_.edited(ledger_.within(*tissue_, rows, state_) - before);
  relocate(mesh, touched, membrane_);
  relocate(mesh, touched, probes_);
  for (auto& seed : seeds_) {
    std::vector<EmbeddedPoint> one{seed.place};
    relocate(mesh, touched, one);
    seed.place = one.front();
  }
}

NeedleView Simulation::start_view(std::span<const int> nodes) const {
  integrator_->complete_at(nodes);
  const Vec vectors[3] = {state_.u.get(), state_.v.get(), state_.a.get()};
  const auto g = gather(vectors, dofs_of(nodes));
  std::vector<NodeState> states;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto of = [&](std::size_t k) { return Vector2{g[k][2 * i], g[k][2 * i + 1]}; };
    states.push_back({of(0), of(1), of(2)});
  }
  return {std::vector<int>(nodes.begin(), nodes.end()), std::move(states)};
}

TrialView Simulation::trial_view(std::span<const int> nodes, const Trial& trial, double h) const {
  const Vec vectors[6] = {
      trial.u,       trial.v, trial.needed.reaction, trial.working.reaction, trial.settled.reaction,
      state_.u.get()};
  const auto g = gather(vectors, dofs_of(nodes));
  std::vector<NodeTrial> trials;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto of = [&](std::size_t k) { return Vector2{g[k][2 * i], g[k][2 * i + 1]}; };
    // A mean of forces goes with the mean velocity: by another one contacts could contradict each other.
    const Vector2 v = trial.means ? (1 / h) * (of(0) - of(5)) : of(1);
    trials.push_back({of(0), v, of(2), of(3), of(4)});
  }
  return {std::vector<int>(nodes.begin(), nodes.end()), std::move(trials)};
}

void Simulation::count_deformed_inversions() {
  if (needle_->tip_contact() == TipContact::open) return;
  const auto nodes = needle_->watched(mesh());
  const NeedleView view = start_view(nodes);
  int inverted = 0;
  for (const int c : mesh().cells_around(needle_->track().tip())) {
    const auto n = mesh().cell(c);
    const auto x = [&](std::size_t i) { return displaced(mesh().point(n[i]), view.at(n[i]).u); };
    if (signed_area(x(0), x(1), x(2)) <= 0) ++inverted;
  }
  counts_.deformed_inversions = std::max(counts_.deformed_inversions, inverted);
}

std::vector<WorldPoint> Simulation::world(std::span<const EmbeddedPoint> points) const {
  if (points.empty()) return {};
  integrator_->complete();
  std::vector<int> dofs;
  for (const auto& point : points) {
    for (const int node : mesh().cell(point.cell)) {
      dofs.push_back(2 * node);
      dofs.push_back(2 * node + 1);
    }
  }
  const Vec vectors[1] = {state_.u.get()};
  const auto u = gather(vectors, dofs)[0];
  std::vector<WorldPoint> world;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vector2 moved;
    for (std::size_t k = 0; k < 3; ++k) {
      moved = moved + points[i].weights[k] * Vector2{u[6 * i + 2 * k], u[6 * i + 2 * k + 1]};
    }
    world.push_back(displaced(points[i].x, moved));
  }
  return world;
}

Vector2 Simulation::curve_reaction(std::size_t curve) const {
  std::array<double, 2> total{};
  for (std::size_t k = 0; k < 2; ++k) {
    const Vec vectors[1] = {reaction_.get()};
    const auto values = gather(vectors, conditions_.curve_dofs(curve, k));
    for (const double value : values[0]) total[k] += value;
  }
  return {total[0], total[1]};
}

double Simulation::fraction() const {
  if (done_) return 1;
  constexpr double nearly = 0.99;  // settling takes as long as it takes
  return estimated_time_ > 0 ? std::min(nearly, state_.t / estimated_time_) : 0;
}

std::vector<double> Simulation::placement_errors() const {
  std::vector<EmbeddedPoint> places;
  for (const auto& seed : seeds_) places.push_back(seed.place);
  const auto world = this->world(places);
  std::vector<double> errors;
  for (std::size_t i = 0; i < seeds_.size(); ++i) {
    const auto target = std::ranges::find(scene_.targets, seeds_[i].target, &Target::name);
    if (target == scene_.targets.end()) {
      errors.push_back(std::nan(""));
    } else if (scene_.time.until_implanted) {
      errors.push_back(distance(seeds_[i].place.x, target->point));
    } else {
      errors.push_back(norm(Vector2{world[i].x - target->point.x, world[i].y - target->point.y}));
    }
  }
  return errors;
}

}  // namespace stylet
