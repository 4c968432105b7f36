#include "stylet/simulation/simulation.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/needle_path.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/recorded.hpp"
#include "stylet/simulation/space_way.hpp"
#include "stylet/simulation/start.hpp"
#include "stylet/simulation/track_binding.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

namespace {

std::vector<EmbeddedPoint> embedded_in(const Mesh& mesh,
                                       std::span<const ReferencePoint> points,
                                       const Scene& scene) {
  std::vector<EmbeddedPoint> embedded;
  int hint = 0;
  for (const auto& x : points) {
    const auto found = locate(mesh, x, hint);
    if (!found) {
      refuse_key(scene, "membrane.polygon",
                 "a vertex lies outside the tissue: " + point_text(scene, x));
    }
    embedded.push_back(*found);
    hint = found->cell;
  }
  return embedded;
}

// Of the tissue along the needle (m).
double extent_of(const Mesh& mesh) {
  if (mesh.dim() == 3) {
    double low[3] = {1e300, 1e300, 1e300};
    double high[3] = {-1e300, -1e300, -1e300};
    for (int node = 0; node < mesh.n_nodes(); ++node) {
      const auto x = mesh.coordinates(node);
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], x[k]);
        high[k] = std::max(high[k], x[k]);
      }
    }
    return norm(Vector3{high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  }
  double first = Axis::along(mesh.point(0));
  double last = first;
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    first = std::min(first, Axis::along(mesh.point(node)));
    last = std::max(last, Axis::along(mesh.point(node)));
  }
  return last - first;
}

// Of a file it has been checked when it was read, and has the document that it was read from.
Scene checked(Scene scene) {
  if (scene.document.kind == Node::Kind::null) check(scene);
  if (scene.file.empty()) scene.file = scene_in_code;
  return scene;
}

}  // namespace

Simulation::Simulation(MPI_Comm comm, Scene scene, bool track_energy, std::unique_ptr<Hand> hand)
    : scene_(in_needle_frame(with_procedure(comm, checked(std::move(scene)), procedure_note_))),
      live_(hand != nullptr || scene_.procedure),
      body_(comm, scene_, live_),
      hand_(std::move(hand)),
      track_energy_(track_energy),
      expected_time_(expected_time(scene_, mesh())) {
  if (hand_ && scene_.procedure) {
    refuse_key(scene_, "procedure",
               "has a hand of its own; allowed: a scene without, for this hand");
  }
  if (scene_.procedure) hand_ = std::make_unique<Recorded>(scene_.procedure->rows);
  if (!hand_) hand_ = std::make_unique<Schedule>(scene_, extent_of(mesh()));
  if (scene_.membrane && scene_.dim() == 2) {
    auto& polygon = scene_.membrane->polygon;
    if (polygon.empty()) polygon = region_outline(mesh(), scene_.membrane->region);
    membrane_ = body_.embed(embedded_in(mesh(), polygon, scene_));
  }
  std::vector<EmbeddedPoint> probes;
  for (const auto& probe : scene_.probes) probes.push_back(*locate(mesh(), probe.point.place()));
  probes_ = body_.embed(probes);
  counts_.worst_quality = body_.rewrites().worst_quality;
  if (scene_.time.method == TimeMethod::explicit_newmark) counts_.stable_step = body_.stable_step();
  if (scene_.start) start_from_checkpoint(comm);
}

void Simulation::start_from_checkpoint(MPI_Comm comm) {
  if (live_) {
    refuse_key(scene_, "start", "a hand begins in tissue at rest; allowed: a scene without");
  }
  StartState start = state_to_start_from(comm, scene_, numbered().file_fingerprint);
  start_fingerprint_ = start.fingerprint;
  restore(std::move(start.state));
  if (start.other_step) hand_->choose_step_anew();
}

StepRecord Simulation::step() {
  try {
    return step_unguarded();
  } catch (const NumericalError& error) {
    throw NumericalError("at t = " + ten_digits(time()) + " s: " + error.what() + held_points());
  }
}

// Held points beside the needle are what it cannot push away: the likely cause of a step that fails.
std::string Simulation::held_points() const {
  if (!needle_ || needle_->track().empty() || needle_->released()) return {};
  if (scene_.dim() == 3) return {};  // it keeps away from them
  std::vector<int> nodes = needle_->watched();
  const int n_dofs = 2 * mesh().n_nodes();
  for (const int dof :
       coordinates_of(needle_->track_operator(), needle_->loaded_points(), n_dofs)) {
    if (dof < n_dofs) nodes.push_back(dof / 2);
  }
  const std::string points = held_points_text(scene_, mesh(), body_.held(), nodes);
  return points.empty() ? points
                        : "; needle '" + needle_->parameters().name +
                              "' meets points that it cannot move: " + points;
}

StepRecord Simulation::step_unguarded() {
  if (!std::exchange(started_, true)) body_.start();
  StepRecord record;
  act_without_time();
  const long long ended = hand_->ended();
  const double wanted = scene_.time.step;
  const bool is_implicit = scene_.time.method == TimeMethod::implicit_newmark;
  double longest = std::min(wanted, body_.stable_step());
  const double tip = needle_ ? needle_->tip() : 0;
  // Sub-steps need not fill the step exactly: the nearest whole number of them does.
  while (!done_ && hand_->ended() == ended && record.h + 0.5 * longest < wanted) {
    const SubStep sub = take_step(body_, *hand_, needle_ ? &*needle_ : nullptr, longest);
    record.h += sub.h;
    ++record.sub_steps;
    record.passes += sub.passes;
    record.iterations += sub.iterations;
    record.needle = sub.needle;
    count(sub);
    const double next = std::min(wanted, body_.stable_step());
    if (is_implicit && next > longest) hand_->choose_step_anew();
    longest = next;
  }
  if (live_ && needle_) count_push(needle_->tip() - tip, record.h);
  act_without_time();
  if (live_) watch_all(gather_all(body().state().u.get()));
  const bool has_ended = !live_ && hand_->ended() != ended;  // a hand and its recording end apart
  if (done_ || has_ended || time() >= next_strain_) watch_strain();
  if (done_ || track_energy_) body_.weigh(done_);
  record.t = time();
  if (record.sub_steps > 0) ++counts_.steps;
  return record;
}

void Simulation::count(const SubStep& step) {
  ++counts_.sub_steps;
  counts_.passes += step.passes;
  counts_.iterations += step.iterations;
  if (needle_) {
    const NeedleCounts before = counts_.needle;
    counts_.needle = earlier_needles_ + needle_->counts();
    count_forces(step.needle.forces, counts_.needle.punctures > before.punctures);
    counts_.largest_aside = std::max(counts_.largest_aside, step.needle.aside);
    watch_tip();
  }
  const MeshRewrites& rewrites = body_.rewrites();
  counts_.edge_flips = rewrites.edge_flips;
  counts_.pattern_rebuilds = rewrites.pattern_rebuilds;
  counts_.worst_quality = rewrites.worst_quality;
  if (counts_.stable_step > 0) {
    counts_.stable_step = std::min(counts_.stable_step, body_.stable_step());
  }
}

// At evenly spaced moments and at the end of every action, of a hand with every seed: a look at all strains
// costs about as much as a whole step.
void Simulation::watch_strain() {
  constexpr double moments = 32;
  constexpr double live_interval = 0.1;  // s
  const double interval = expected_time_ / moments;
  next_strain_ = time() + (interval > 0 && !live_ ? interval : live_interval);
  const auto u = gather_all(body().state().u.get());
  // In space the mesh has the far field alone.
  const bool is_in = needle_ && !needle_->track().empty() && scene_.dim() == 2;
  raise(largest_strain_, mesh(), u, time(), is_in ? &needle_->track() : nullptr,
        is_in ? needle_->parameters().cutting.tip_length : 0);
  watch_all(u);
}

void Simulation::count_push(double way, double duration) {
  if (!(way > 0)) return;
  Pushing& pushing = pushings_.back();
  pushing.duration += duration;
  pushing.furthest = std::max(pushing.furthest, way);
}

// Enters needles, implants seeds, changes numbers, and ends the run.
void Simulation::act_without_time() {
  while (!done_) {
    const Wish wish = hand_->next();
    if (wish.kind == Wish::Kind::step) return;
    try {
      fulfil(wish);
    } catch (const InputError& error) {
      hand_->refused();
      if (!scene_.procedure) throw;
      throw InputError(procedure_path(scene_) + ": " + error.what());
    } catch (const Error&) {
      hand_->refused();
      throw;
    }
  }
}

void Simulation::fulfil(const Wish& wish) {
  switch (wish.kind) {
    case Wish::Kind::step:
      break;
    case Wish::Kind::enter:
      enter(*wish.needle);
      break;
    case Wish::Kind::implant:
      implant(wish.target);
      break;
    case Wish::Kind::change:
      change(wish.key, wish.value);
      hand_->changed();
      break;
    case Wish::Kind::done:
      done_ = true;
      break;
  }
}

void Simulation::enter(const NeedleParameters& parameters) {
  if (needle_ && !needle_->released()) {
    throw NumericalError("needle '" + parameters.name + "' enters while needle '" +
                         needle_->parameters().name + "' is in the tissue; take it out before");
  }
  if (live_) {
    check_needle(scene_, parameters);
    body_.expect(parameters);
  }
  double skin_at_rest = 0;
  if (scene_.dim() == 2) {
    const Entry entry = find_entry(mesh(), {parameters.height}, parameters.name);
    make_needle(parameters, met_in_tissue());
    std::vector<int> nodes{entry.node, entry.neighbour};
    std::ranges::sort(nodes);
    body_.apply(needle_->enter(entry, body_.view(nodes)), &needle_->track());
    skin_at_rest = Axis::along(entry.x);
  } else {
    make_needle(parameters, met_in_tissue());
  }
  largest_tip_force_ = 0;
  last_friction_ = 0;
  since_entered_ = {};
  if (live_) {
    entered_.push_back(parameters);
    pushings_.push_back({parameters.name});
  }
  hand_->entered(needle_->skin(), skin_at_rest);
}

// The needle before, if there is one, has left the tissue.
NeedleTissue Simulation::met_in_tissue() {
  NeedleTissue tissue;
  if (needle_) {
    earlier_needles_ = counts_.needle;
    tissue.earlier = needle_->leave();
    scene_.dim() == 2 ? body_.put_mesh_back() : body_.leave_track();
  }
  if (scene_.membrane) {
    tissue.membrane = scene_.membrane->polygon;
    tissue.puncture_force = scene_.membrane->puncture_force;
  }
  tissue.region_modulus = region_modulus();
  return tissue;
}

void Simulation::make_needle(const NeedleParameters& parameters, NeedleTissue tissue) {
  const bool by_velocity = body_.decides_by_velocity();
  if (scene_.dim() == 2) {
    needle_.emplace(mesh(), parameters, std::move(tissue), by_velocity);
  } else {
    needle_.emplace(parameters, make_path(scene_, mesh(), parameters, std::move(tissue)),
                    by_velocity);
  }
  body_.follow(needle_->track_operator());
}

std::string Simulation::why_no_seed() const {
  if (!needle_) return "a seed is to be left before a needle has entered";
  return stylet::why_no_seed(*needle_, largest_tip_force_);
}

std::vector<double> Simulation::region_modulus() const {
  std::vector<double> modulus(mesh().data().region_names.size());
  for (const auto& region : scene_.tissue.regions) {
    modulus[static_cast<std::size_t>(mesh().region_index(region.region))] =
        region.material.youngs_modulus;
  }
  return modulus;
}

void Simulation::implant(const std::string& target) {
  if (!needle_) throw NumericalError(why_no_seed());
  if (!target.empty() &&
      std::ranges::find(scene_.targets, target, &Target::name) == scene_.targets.end()) {
    throw InputError("a seed for target '" + target + "', which the scene does not have");
  }
  if (live_) {
    watch_strain();
  } else {
    watch_all(gather_all(body().state().u.get()));
  }
  const bool only = target.empty() && scene_.targets.size() == 1;
  seeds_.push_back(
      leave_seed(body_, *needle_, only ? scene_.targets[0].name : target, largest_tip_force_));
  seeds_.back().turned_over = since_entered_.triangles;
  hand_->implanted();
}

ConstraintSet Simulation::constraints() const {
  ConstraintSet set;
  if (needle_ && !needle_->released())
    set = body_.beside_held(needle_->conditions(), needle_->track_operator());
  set.dofs.insert(set.dofs.end(), body_.held().begin(), body_.held().end());
  return set;
}

void Simulation::count_forces(const NeedleForces& forces, bool punctured) {
  largest_tip_force_ = std::max(largest_tip_force_, forces.tip);
  double peak = std::abs(forces.total());
  // What broke within the step bore its force there, and the tip has fallen back since.
  if (punctured) peak = std::max(peak, std::abs(scene_.membrane->puncture_force + last_friction_));
  counts_.peak_needle_force = std::max(counts_.peak_needle_force, peak);
  last_friction_ = forces.friction;
  if (needle_->parameters().cutting.law == CuttingLaw::increment && !punctured) {
    const double excess = forces.tip - needle_->force_to_cut();
    counts_.tip_excess = std::max(counts_.tip_excess, excess);
  }
}

void Simulation::watch_tip() {
  if (needle_->tip_contact() == TipContact::open || scene_.dim() == 3) return;
  const auto nodes = needle_->watched();
  const NeedleView view = body_.view(nodes);
  TurnedOver seen;
  seen.time = time();
  for (const int c : mesh().cells_around(needle_->track().tip())) {
    const auto n = mesh().cell(c);
    if (is_turned_over(mesh(), c, {view.at(n[0]).u, view.at(n[1]).u, view.at(n[2]).u})) {
      seen.add(mesh(), c);
    }
  }
  turned_over_.raise(seen);
  since_entered_.raise(seen);
}

void Simulation::watch_all(std::span<const double> u) {
  turned_over_now_ = stylet::turned_over(mesh(), u, time());
  turned_over_.raise(turned_over_now_);
  since_entered_.raise(turned_over_now_);
}

double Simulation::fraction() const {
  if (done_) return 1;
  constexpr double nearly = 0.99;  // settling takes as long as it takes
  return expected_time_ > 0 ? std::min(nearly, time() / expected_time_) : 0;
}

std::vector<double> Simulation::placement_errors() const {
  std::vector<EmbeddedPoint> places;
  for (const auto& seed : seeds_) places.push_back(place_of(seed));
  const auto world = body_.world(places);
  std::vector<double> errors;
  for (std::size_t i = 0; i < seeds_.size(); ++i) {
    const auto target = std::ranges::find(scene_.targets, seeds_[i].target, &Target::name);
    if (target == scene_.targets.end() || hides_places(scene_)) {
      errors.push_back(std::nan(""));
    } else if (scene_.time.until_implanted) {
      errors.push_back(distance(places[i].x, *target));
    } else {
      errors.push_back(distance(world[i], *target));
    }
  }
  return errors;
}

}  // namespace stylet
