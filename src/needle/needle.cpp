#include "stylet/needle/needle.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/base/text.hpp"
#include "stylet/needle/cut_path.hpp"
#include "stylet/needle/friction.hpp"
#include "stylet/needle/slack.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stylet {

const char* name_of(NeedlePhase phase) {
  switch (phase) {
    case NeedlePhase::outside:
      return "outside";
    case NeedlePhase::inserting:
      return "inserting";
    case NeedlePhase::holding:
      return "holding";
    case NeedlePhase::retracting:
      return "retracting";
    case NeedlePhase::withdrawn:
      break;
  }
  return "withdrawn";
}

Needle::Needle(NeedleParameters parameters,
               std::unique_ptr<ReferencePath> path,
               bool velocity_level)
    : parameters_(std::move(parameters)), velocity_level_(velocity_level), path_(std::move(path)) {}

Needle::Needle(const Mesh& mesh,
               NeedleParameters parameters,
               NeedleTissue tissue,
               bool velocity_level)
    : Needle(parameters,
             std::make_unique<CutPath>(mesh,
                                       Axis{parameters.height},
                                       parameters.cutting.tip_length,
                                       0.5 * parameters.diameter,
                                       stylet::searches(parameters.cutting),
                                       std::move(tissue)),
             velocity_level) {}

NeedleEdits Needle::enter(const Entry& entry, const NeedleView& start) {
  const NodeState state =
      interpolate(entry.fraction, start.at(entry.node), start.at(entry.neighbour));
  skin_along_ = Axis::along(displaced(entry.x, state.u));
  tip_along_ = skin_along_;
  return path_->enter(entry, start);
}

void Needle::change(const CuttingParameters& cutting,
                    const std::optional<FrictionParameters>& friction,
                    double puncture_force,
                    std::vector<double> region_modulus) {
  parameters_.cutting = cutting;
  parameters_.friction = friction;
  path_->change(puncture_force, std::move(region_modulus));
}

std::vector<int> Needle::loaded_points() const {
  std::vector<int> points = path_->loaded_points();
  for (const auto& force : work_.last()) points.push_back(force.point);
  sort_unique(points);
  return points;
}

double Needle::full_threshold() const {
  const bool scales = parameters_.cutting.stiffness_share > 0;
  return full_force(parameters_.cutting, scales ? path_->modulus_ahead() : 0);
}

// Zero where the way is cut already. A tip that is not in with all of its length cuts with that part
// of its force: at the skin the needle begins to cut at once, and how deep it is has a limit on finer
// meshes, at every depth. (A full force on the first bit of path is a point force: the dent that it
// makes grows with the logarithm of the element size, and the tip jumps when the skin gives way.)
double Needle::threshold() const {
  return path_->is_free() ? 0 : path_->share_in() * full_threshold();
}

// Tip force beyond which what is ahead gives way (N).
double Needle::limit() const {
  return path_->at_membrane() ? path_->puncture_force() : threshold();
}

double Needle::force_to_cut() const {
  return path_->at_membrane() ? path_->puncture_force() : full_threshold();
}

void Needle::start_step(const NeedleStep& step) {
  step_ = step;
  phase_ = step.speed() > 0   ? NeedlePhase::inserting
           : step.speed() < 0 ? NeedlePhase::retracting
                              : NeedlePhase::holding;
  const CuttingLaw law = parameters_.cutting.law;
  // One cut a step: a hand that goes further would leave its tip behind.
  if (law == CuttingLaw::increment &&
      step.to - step.from > 1.000001 * parameters_.cutting.increment) {
    throw NumericalError("needle '" + parameters_.name + "' goes " +
                         ten_digits(step.to - step.from) + " m in a step, but cuts " +
                         ten_digits(parameters_.cutting.increment) +
                         " m at most; take a larger cutting.increment, a smaller time.step, or a "
                         "slower hand");
  }
  double advance = 0;
  // A tip that keeps cutting will advance about as far as last time.
  const bool keeps_cutting = tip_ == TipContact::cut && step.speed() > 0 && searches();
  if (keeps_cutting && !path_->is_uncut()) advance = path_->advanced();
  if (tip_ != TipContact::open) {
    if (law == CuttingLaw::lagged) advance = pending_;
    if (law == CuttingLaw::increment && step.speed() > 0 && last_tip_force_ >= limit()) {
      if (path_->at_membrane()) path_->puncture();
      advance = parameters_.cutting.increment;
    }
    pending_ = 0;
    if (path_->at_membrane()) advance = 0;
  }
  path_->start_step(advance);
  contacts_.start_step(path_->track());
  forget_search();
}

void Needle::shorten_step(const NeedleStep& step) {
  step_ = step;
  forget_search();
}

void Needle::forget_search() {
  search_.forget();
  holds_beyond_.reset();
}

NeedleEdits Needle::plan(const NeedleView& start) {
  contacts_.forget_changes(path_->track());
  const long long base = path_->base();
  try {
    ReferencePath::Plan plan = path_->plan(start);
    if (path_->base() != base) forget_search();
    if (plan.holds) tip_ = TipContact::stick;
    return std::move(plan.edits);
  } catch (const ReferencePath::Blocked& blocked) {
    throw NumericalError("needle '" + parameters_.name + "' cannot advance, " +
                         ten_digits(tip_along_ - skin_along_) +
                         " m behind its entry point: " + blocked.what());
  }
}

TrackConditions Needle::conditions() const {
  TrackConditions set;
  const auto points = path_->track().nodes();
  const auto friction =
      parameters_.friction ? path_->shaft_lengths() : std::vector<double>(points.size(), 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& shaft = points[i];
    if (!shaft.attached) continue;
    const int point = static_cast<int>(i);
    path_->guide(point, set.held);
    if (friction[i] <= 0) continue;
    const TrackPlace along{point, Component::along};
    if (shaft.contact == Contact::stick) {
      set.held.push_back({along, step_.speed(), true});
    } else {
      set.forces.push_back(
          {along, shaft.slip_sign * sliding_force(*parameters_.friction, friction[i])});
      const double viscous = viscous_coefficient(*parameters_.friction, friction[i]);
      if (viscous > 0) set.dashpots.push_back({along, viscous, step_.speed()});
    }
  }
  if (tip_ == TipContact::open) return set;
  const double f = threshold();
  TrackMean mean{path_->tip_shares()};
  if (tip_ == TipContact::cut && f > 0) {
    for (const auto& [point, share] : mean.shares) {
      set.forces.push_back({{point, Component::along}, f * share});
    }
  }
  if (tip_ == TipContact::stick) {
    mean.value = step_.to - path_->tip_along();
    mean.rate = step_.speed();
    mean.by_rate = holds_by_rate();
    mean.rest = path_->tip_rest();
    set.mean = mean;
  }
  return set;
}

// How far the needle is ahead of the tissue at its tip (m), by positions.
double Needle::place_gap(const TrackTrial& trial) const {
  double mean_u = 0;
  for (const auto& [point, share] : path_->tip_shares()) {
    mean_u += share * trial.at(point).u.along;
  }
  if (tip_ == TipContact::cut) mean_u += path_->tip_rest() * threshold();
  return step_.to - path_->tip_along() - mean_u;
}

// The same as the integrator sees it.
double Needle::gap(const TrackTrial& trial) const {
  const double gap = place_gap(trial);
  if (!velocity_level_) return gap;
  double mean_v = 0;
  for (const auto& [point, share] : path_->tip_shares()) {
    mean_v += share * trial.at(point).v.along;
  }
  const double closing = step_.h * (step_.speed() - mean_v);
  // Tissue that a condition by rate left ahead of the tip, or behind it, touches it.
  if (holds_by_rate())
    return (tip_ == TipContact::open ? std::min(gap, 0.0) : std::max(gap, 0.0)) + closing;
  return gap + closing;
}

std::vector<PointForce> Needle::tip_forces(const Multiplier& lambda) const {
  std::vector<PointForce> forces;
  for (const auto& [point, share] : path_->tip_shares()) {
    PointForce& force = force_on(forces, point);
    force.along = share * lambda.working;
    force.settled_along = share * lambda.settled;
  }
  return forces;
}

// A straight way through the tissue as it was is right as long as nothing ahead of the tip moves aside.
double Needle::taken_aside(const TrackStart& start) {
  const std::size_t before = std::exchange(n_points_, path_->track().size());
  if (path_->n_components() < 3) return 0;
  double aside = 0;
  for (std::size_t i = before; i < n_points_; ++i) {
    const TrackVector& u = start.at(static_cast<int>(i));
    aside = std::max(aside, std::hypot(u.across, u.across_too));
  }
  return aside;
}

NeedleStepReport Needle::commit(const TrackStart& start,
                                const TrackTrial& trial,
                                Multiplier lambda,
                                double end_weight) {
  NeedleStepReport report;
  if (tip_ == TipContact::cut) lambda = threshold();
  if (tip_ == TipContact::open) lambda = 0;
  report.forces.tip = lambda.settled;
  last_tip_force_ = report.forces.tip;
  check_tip(trial, lambda.bearing());
  if (tip_ == TipContact::cut && parameters_.cutting.law == CuttingLaw::lagged) {
    pending_ = std::max(0.0, place_gap(trial));
  }
  report.aside = taken_aside(start);
  std::vector<PointForce> forces = tip_forces(lambda);
  report.contact_changes = contacts_.changes();
  if (parameters_.friction) {
    const auto shaft = contacts_.commit(path_->track(), path_->shaft_lengths(), trial,
                                        *parameters_.friction, step_.speed(), forces);
    report.forces.friction = shaft.force;
    report.n_stick = shaft.n_stick;
    report.n_slip = shaft.n_slip;
  }
  const auto points = path_->track().nodes();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].attached) continue;
    const int point = static_cast<int>(i);
    PointForce& force = force_on(forces, point);
    force.across = trial.at(point).working.across;
    force.settled_across = trial.at(point).settled.across;
    force.across_too = trial.at(point).working.across_too;
    force.settled_across_too = trial.at(point).settled.across_too;
  }
  const auto sums = work_.book(step_, start, trial, std::move(forces), end_weight);
  report.work = sums.work;
  report.dissipated = sums.dissipated;
  if (tip_ == TipContact::open) {
    path_->uncover(step_.to, trial, parameters_.friction, step_.speed());
    if (released()) phase_ = NeedlePhase::withdrawn;
  }
  tip_along_ = step_.to;
  if (std::exchange(punctures_, counts().punctures) < counts().punctures) {
    puncture_at_ = deepest_since_ = tip_along_;
  }
  deepest_since_ = std::max(deepest_since_, tip_along_);
  return report;
}

TipStand Needle::stand() const {
  TipStand stand{pending_, last_tip_force_, force_to_cut(), path_->element_size(), at_membrane()};
  if (puncture_at_) {
    stand.since_puncture = (deepest_since_ - *puncture_at_) / (tip_along_ - skin_along_);
  }
  return stand;
}

double Needle::slack() const {
  return force_slack * nominal_force(parameters_.cutting);
}

}  // namespace stylet
