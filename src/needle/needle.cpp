#include "stylet/needle/needle.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/base/text.hpp"
#include "stylet/needle/membrane.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stylet {

namespace {

// Contacts change all at once until one of them has changed this often on the same mesh.
constexpr int hasty_changes = 3;
// Then so often without getting fewer.
constexpr int most_patience = 10;
// Flips in a step that only make way for the tip.
constexpr int most_passages = 20;
// Of the advance of the needle in a step: what a consistent cut leaves open goes to the next step.
constexpr double gap_tolerance = 1e-4;
// Relative slack of force thresholds against round-off of the solver.
constexpr double force_slack = 1e-9;
// A hand-over that leaves a worse triangle is refused.
constexpr double quality_floor = 0.03;

}  // namespace

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

Needle::Needle(NeedleParameters parameters, NeedleTissue tissue, bool velocity_level)
    : parameters_(std::move(parameters)),
      tissue_(std::move(tissue)),
      velocity_level_(velocity_level),
      axis_{parameters_.height},
      motion_(parameters_.motion) {}

NeedleEdits Needle::enter(const Entry& entry, const NeedleView& start) {
  const NodeState state =
      interpolate(entry.fraction, start.at(entry.node), start.at(entry.neighbour));
  track_.push({entry.node});
  motion_.enter(axis_.along(displaced(entry.x, state.u)), Axis::along_sign);
  NeedleEdits edits;
  if (entry.fraction > 0) edits.moves.push_back({entry.node, entry.x, state});
  return edits;
}

std::vector<int> Needle::watched(const Mesh& mesh) const {
  auto nodes = mesh.neighbours(track_.tip());
  for (const auto& shaft : track_.nodes()) nodes.push_back(shaft.node);
  sort_unique(nodes);
  return nodes;
}

std::vector<int> Needle::shaft_nodes() const {
  std::vector<int> nodes;
  for (const auto& shaft : track_.nodes()) nodes.push_back(shaft.node);
  std::ranges::sort(nodes);
  return nodes;
}

double Needle::threshold(const Mesh& mesh) const {
  const auto& cutting = parameters_.cutting;
  double share = 1;
  if (cutting.stiffness_share > 0) {
    // The element furthest ahead of the tip.
    int ahead = -1;
    double furthest = -std::numeric_limits<double>::infinity();
    for (const int c : mesh.cells_around(track_.tip())) {
      double along = 0;
      for (const int node : mesh.cell(c)) along += Axis::along(mesh.point(node)) / 3;
      if (along > furthest) {
        furthest = along;
        ahead = c;
      }
    }
    const double e = tissue_.region_modulus[static_cast<std::size_t>(mesh.region(ahead))];
    share += cutting.stiffness_share * (e / cutting.reference_youngs_modulus - 1);
  }
  return cutting.cutting_force / cutting.sharpness * share;
}

std::vector<double> Needle::tip_weights(const Mesh& mesh) const {
  const double path = track_.distances(mesh).front();
  const double zone = std::min(parameters_.cutting.tip_length, path);
  if (zone <= 0) {
    std::vector<double> weights(track_.size(), 0.0);
    weights.back() = 1;
    return weights;
  }
  auto weights = track_.lengths(mesh, 0, zone);
  for (double& weight : weights) weight /= zone;
  return weights;
}

std::vector<double> Needle::friction_lengths(const Mesh& mesh) const {
  const double path = track_.distances(mesh).front();
  auto lengths = track_.lengths(mesh, exposed_ + parameters_.cutting.tip_length, path);
  if (lengths.size() > 1) {
    // The tip node obeys the tip's law alone; the shaft that it stands for goes to its neighbour, also
    // where the tip is open: a force that came and went with the contact would let it cycle.
    lengths[lengths.size() - 2] += lengths.back();
    lengths.back() = 0;
  }
  return lengths;
}

void Needle::start_step(const Mesh& mesh, const NeedleStep& step) {
  step_ = step;
  phase_ = step.speed() > 0   ? NeedlePhase::inserting
           : step.speed() < 0 ? NeedlePhase::retracting
                              : NeedlePhase::holding;
  new_base();
  passages_ = 0;
  // A tip that keeps cutting will advance about as far as last time.
  const bool keeps_cutting = tip_ == TipContact::cut && step.speed() > 0 &&
                             parameters_.cutting.law == CuttingLaw::consistent;
  remaining_ = keeps_cutting && track_.size() > 1 ? advanced_ : 0;
  guessing_ = remaining_ > 0;
  advanced_ = 0;
  contact_changes_ = 0;
  same_side_ = 0;
  forget_changes();
  if (tip_ == TipContact::open) return;
  if (parameters_.cutting.law == CuttingLaw::lagged) remaining_ = pending_;
  if (parameters_.cutting.law == CuttingLaw::increment && step.speed() > 0) {
    const double limit = membrane_edge_ ? tissue_.puncture_force : threshold(mesh);
    if (last_tip_force_ >= limit) {
      if (membrane_edge_) {
        punctured_.insert(*membrane_edge_);
        membrane_edge_.reset();
        ++counts_.punctures;
      }
      remaining_ = parameters_.cutting.increment;
    }
  }
  pending_ = 0;
  if (membrane_edge_) remaining_ = 0;
}

void Needle::forget_changes() {
  for (auto& shaft : track_.nodes()) shaft.changes = 0;
  fewest_wrong_ = std::numeric_limits<std::size_t>::max();
  patience_ = most_patience;
}

// The next plan looks for the way again, from where the tip then stands.
void Needle::new_base() {
  base_.reset();
  b_ = 0;
  postponed_ = false;
  last_gap_.reset();
  too_short_.reset();
  too_far_.reset();
}

// The largest b from base_: hand-over, or the membrane (then pending_membrane_edge_ is set).
double Needle::cap() {
  pending_membrane_edge_.reset();
  const double end = postponed_ ? base_->reach : std::min(base_->hand_over, base_->reach);
  double limit = std::max(end, b_);
  if (!tissue_.membrane.empty()) {
    const auto crossing =
        first_crossing(tissue_.membrane, base_->p, base_->r, base_->distance, punctured_);
    if (crossing && crossing->distance <= limit) {
      limit = crossing->distance;
      pending_membrane_edge_ = crossing->edge;
    }
  }
  return limit;
}

NeedleEdits Needle::plan(const Mesh& mesh, const NeedleView& start) {
  NeedleEdits edits;
  forget_changes();
  const int tip = track_.tip();
  const auto stuck = [&](const std::string& why) {
    const auto p = mesh.point(tip);
    return NumericalError("needle '" + parameters_.name + "' cannot advance at (" +
                          std::to_string(p.x) + ", " + std::to_string(p.y) + ") m: " + why);
  };
  if (!base_) {
    base_ = find_way(mesh, track_, axis_, start);
    if (!base_) throw stuck("its tip has reached the boundary of the tissue");
    if (base_->fell_back) ++counts_.fallbacks;
  }
  // The first cut goes half-way to the edge ahead at once; a membrane in its way is met at the skin.
  const double first_cut = 0.5 * base_->distance;
  if (track_.size() == 1 && !tissue_.membrane.empty()) {
    const auto crossing =
        first_crossing(tissue_.membrane, base_->p, base_->r, first_cut, punctured_);
    if (crossing) {
      membrane_edge_ = crossing->edge;
      tip_ = TipContact::stick;
      hand_over_wanted_ = false;
      remaining_ = 0;
      return edits;
    }
  }
  if (hand_over_wanted_ || track_.size() == 1) {
    auto hand_over = plan_hand_over(mesh, track_, *base_, start);
    const double quality = hand_over ? hand_over->quality : 0;
    // A poor hand-over waits until the tip has come closer to the edge ahead.
    constexpr double fair_quality = 0.1;
    constexpr double further = 0.02;  // of the distance to the edge ahead
    if (quality < fair_quality && track_.size() > 1 &&
        base_->reach > b_ + further * base_->distance) {
      postponed_ = true;
      hand_over_wanted_ = false;
      return edits;
    }
    if (quality < quality_floor) {
      // Other nodes come within reach if an edge is flipped.
      const auto passage = plan_passage(mesh, track_, *base_);
      if (!passage || ++passages_ > most_passages) {
        throw stuck(
            "no node near its tip can become the next one (they are held, or an element would "
            "become too thin); refine the mesh or move the needle");
      }
      edits.flips.push_back(*passage);
      hand_over_wanted_ = false;
      new_base();
      return edits;
    }
    if (track_.size() == 1) {
      remaining_ = std::max(0.0, remaining_ - first_cut);
      advanced_ += first_cut;
    }
    hand_over_wanted_ = false;
    const Contact inherited = track_.nodes().back().contact;
    track_.push({hand_over->new_tip, true, inherited, track_.nodes().back().slip_sign, 0});
    ++counts_.hand_overs;
    new_base();
    return hand_over->edits;
  }
  const double limit = cap();
  double to = std::max(0.0, b_ + remaining_);
  remaining_ = 0;
  if (guessing_) to = std::min(to, limit);
  if (to >= limit && !guessing_) {
    if (pending_membrane_edge_) {
      membrane_edge_ = pending_membrane_edge_;
      tip_ = TipContact::stick;
    } else {
      hand_over_wanted_ = true;
      remaining_ = to - limit;
    }
    to = limit;
  }
  guessing_ = false;
  if (to != b_) {
    advanced_ += to - b_;
    b_ = to;
    edits.moves.push_back(advanced(*base_, tip, b_));
  }
  return edits;
}

ConstraintSet Needle::constraints(const Mesh& mesh) const {
  ConstraintSet set;
  const auto nodes = track_.nodes();
  const auto friction =
      parameters_.friction ? friction_lengths(mesh) : std::vector<double>(nodes.size(), 0.0);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto& shaft = nodes[i];
    if (!shaft.attached) continue;
    set.dofs.push_back({Axis::across_dof(shaft.node),
                        axis_.across_position - Axis::across(mesh.point(shaft.node))});
    if (friction[i] <= 0) continue;
    if (shaft.contact == Contact::stick) {
      set.dofs.push_back({Axis::along_dof(shaft.node), Axis::along_sign * step_.speed(), true});
    } else {
      const double force = shaft.slip_sign * parameters_.friction->kinetic_force * friction[i];
      set.forces.push_back({Axis::along_dof(shaft.node), Axis::along_sign * force});
    }
  }
  if (tip_ == TipContact::open) return set;
  const auto weights = tip_weights(mesh);
  const double f = threshold(mesh);
  MeanCondition mean;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (weights[i] == 0) continue;
    const int dof = Axis::along_dof(nodes[i].node);
    mean.weights.push_back({dof, Axis::along_sign * weights[i]});
    if (tip_ == TipContact::cut) set.forces.push_back({dof, Axis::along_sign * f * weights[i]});
  }
  if (tip_ == TipContact::stick) {
    mean.value = step_.to - Axis::along(mesh.point(track_.tip()));
    mean.rate = step_.speed();
    mean.by_rate = holds_by_rate();
    set.mean = mean;
  }
  return set;
}

double Needle::gap(const Mesh& mesh, const TrialView& trial) const {
  const auto weights = tip_weights(mesh);
  double mean_u = 0;
  double mean_v = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const auto& node = trial.at(track_.nodes()[i].node);
    mean_u += weights[i] * Axis::along(node.u);
    mean_v += weights[i] * Axis::along(node.v);
  }
  const double gap = step_.to - Axis::along(mesh.point(track_.tip())) - mean_u;
  if (!velocity_level_) return gap;
  const double closing = step_.h * (step_.speed() - mean_v);
  // Tissue that a condition by rate left ahead of the tip, or behind it, touches it.
  if (holds_by_rate())
    return (tip_ == TipContact::open ? std::min(gap, 0.0) : std::max(gap, 0.0)) + closing;
  return gap + closing;
}

bool Needle::review(const Mesh& mesh, const TrialView& trial, const Multiplier& lambda) {
  if (parameters_.friction && !review_friction(mesh, trial)) {
    // Another contact, another gap.
    last_gap_.reset();
    too_short_.reset();
    too_far_.reset();
    return false;
  }
  return review_tip(mesh, trial, lambda);
}

// All contacts change at once where they must, which is fast and may cycle. Where the mesh has not
// changed for long, nodes that have slid have one limit of force for sticking and sliding: that is
// Tresca's problem, which has one solution, and block pivoting finds it (Portugal, Judice and Vicente
// 1994): all that must change as long as they get fewer, else the last one alone.
bool Needle::review_friction(const Mesh& mesh, const TrialView& trial) {
  const auto lengths = friction_lengths(mesh);
  const auto& friction = *parameters_.friction;
  const bool careful = std::ranges::any_of(
      track_.nodes(), [](const ShaftNode& n) { return n.changes >= hasty_changes; });
  std::vector<std::size_t> wrong;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const auto& shaft = track_.nodes()[i];
    if (!shaft.attached || lengths[i] <= 0) continue;
    const auto& node = trial.at(shaft.node);
    if (shaft.contact == Contact::stick) {
      const bool has_slid = careful && shaft.changes > 0;
      const double limit = (has_slid ? friction.kinetic_force : friction.static_force) * lengths[i];
      if (std::abs(Axis::along(node.reaction)) > limit * (1 + force_slack)) wrong.push_back(i);
    } else {
      // A sign that contradicts the new velocity turns into stick (model.md, section 6).
      const double relative = step_.speed() - Axis::along(node.v);
      const double noise = 1e-9 * friction.stick_speed;
      if (shaft.slip_sign * relative < -noise) wrong.push_back(i);
    }
  }
  if (wrong.empty()) return true;
  if (careful) {
    if (wrong.size() < fewest_wrong_) {
      fewest_wrong_ = wrong.size();
      patience_ = most_patience;
    } else if (patience_ > 0) {
      --patience_;
    } else {
      wrong = {wrong.back()};
    }
  }
  for (const std::size_t i : wrong) {
    auto& shaft = track_.nodes()[i];
    if (shaft.contact == Contact::stick) {
      shaft.contact = Contact::slip;
      shaft.slip_sign = Axis::along(trial.at(shaft.node).reaction) > 0 ? 1 : -1;
    } else {
      shaft.contact = Contact::stick;
    }
    ++shaft.changes;
  }
  contact_changes_ += static_cast<int>(wrong.size());
  return false;
}

bool Needle::review_tip(const Mesh& mesh, const TrialView& trial, const Multiplier& lambda) {
  const double tolerance = gap_tolerance * std::max(std::abs(step_.to - step_.from), 1e-9);
  switch (tip_) {
    case TipContact::stick: {
      const double f = threshold(mesh);
      const double limit = membrane_edge_ ? tissue_.puncture_force : f;
      if (lambda.needed < -force_slack * f) {
        tip_ = TipContact::open;
        return false;
      }
      if (parameters_.cutting.law == CuttingLaw::increment) return true;
      // Before a blow or after it: the smaller one, so that a cut that follows lets the tissue fall back.
      // What only backward Euler has, one force over the whole step, is itself the force before.
      const bool one_force = lambda.needed == lambda.working;
      const double before = one_force ? lambda.needed : 2 * lambda.working - lambda.settled;
      if (std::min(before, lambda.settled) <= limit * (1 + force_slack)) return true;
      if (membrane_edge_) {
        punctured_.insert(*membrane_edge_);
        membrane_edge_.reset();
        ++counts_.punctures;
        new_base();
      }
      tip_ = TipContact::cut;
      return false;
    }
    case TipContact::cut: {
      const double g = gap(mesh, trial);
      if (parameters_.cutting.law == CuttingLaw::consistent) {
        if (std::abs(g) <= tolerance) return true;
        return cut_further(g);
      }
      if (g >= -tolerance) return true;
      tip_ = TipContact::stick;
      return false;
    }
    case TipContact::open:
      break;
  }
  if (gap(mesh, trial) <= tolerance) return true;
  tip_ = TipContact::stick;
  exposed_ = 0;
  for (auto& shaft : track_.nodes()) {
    if (shaft.attached) continue;
    shaft.attached = true;
    shaft.contact = Contact::stick;
  }
  return false;
}

// Secant on the advance: the gap falls by about as much as the tip advances, but by several times as
// much where a point tip has squeezed the element ahead. So the secant stays between the last
// advance that was too short and the last that was too far; where it does not, their middle is taken.
bool Needle::cut_further(double g) {
  double slope = -1;
  const bool stands = last_gap_ && last_gap_->b == b_;
  if (last_gap_ && last_gap_->b != b_) {
    const double secant = (g - last_gap_->gap) / (b_ - last_gap_->b);
    constexpr double shallowest = -0.3;
    if (secant < shallowest) slope = secant;
  }
  last_gap_ = {b_, g};
  (g > 0 ? too_short_ : too_far_) = last_gap_;
  double to = b_ - g / slope;
  // A tip in tissue that is squeezed flat gains little by its advance: longer and longer ones, until
  // one is too far or the next hand-over is reached.
  same_side_ = g > 0 && !too_far_ ? same_side_ + 1 : 0;
  constexpr int slow = 4;
  constexpr int most_doublings = 20;
  if (same_side_ > slow) {
    to = b_ - g / slope * std::exp2(std::min(same_side_ - slow, most_doublings));
    guessing_ = !stands;
  }
  if (too_short_ && too_far_) {
    const double low = std::min(too_short_->b, too_far_->b);
    const double high = std::max(too_short_->b, too_far_->b);
    constexpr double inner = 0.01;  // of the bracket: closer to its ends is no progress
    const double margin = inner * (high - low);
    if (!(to > low + margin && to < high - margin)) to = 0.5 * (low + high);
    constexpr double narrow = 1e-14;  // m
    if (high - low < narrow) {
      throw NumericalError("the advance of needle '" + parameters_.name +
                           "' has no solution: " + exact(b_) + " m leave a gap that jumps from " +
                           exact(too_short_->gap) + " m to " + exact(too_far_->gap) +
                           " m (allowed: " + exact(gap_tolerance) +
                           " of the step); take another time.step or mesh");
    }
  }
  if (to <= 0) {
    // Less than nothing to cut: the tip sticks.
    remaining_ = -b_;
    tip_ = TipContact::stick;
    return false;
  }
  remaining_ = to - b_;
  return false;
}

void Needle::book_work(const NeedleView& start,
                       const TrialView& trial,
                       const AlongForces& forces,
                       double end_weight,
                       NeedleStepReport& report) {
  for (std::size_t i = 0; i < forces.working.size(); ++i) {
    auto& shaft = track_.nodes()[i];
    const auto& node = trial.at(shaft.node);
    const bool held = shaft.attached;
    const auto mean = [&](double last, double now) {
      return (1 - end_weight) * last + end_weight * now;
    };
    const double along = mean(shaft.along_force, forces.working[i]);
    const double across = mean(shaft.across_force, held ? Axis::across(node.working) : 0);
    shaft.along_force = forces.settled[i];
    shaft.across_force = held ? Axis::across(node.settled) : 0;
    // The needle guides a node that joins it on to its axis: work too.
    const Vector2 moved = node.u - start.at(shaft.node).u;
    const double hand = step_.to - step_.from;
    report.work += along * hand + across * Axis::across(moved);
    report.dissipated += along * (hand - Axis::along(moved));
  }
}

NeedleStepReport Needle::commit(const Mesh& mesh,
                                const NeedleView& start,
                                const TrialView& trial,
                                Multiplier lambda,
                                double end_weight) {
  NeedleStepReport report;
  const double v = step_.speed();
  if (tip_ == TipContact::cut) lambda = threshold(mesh);
  if (tip_ == TipContact::open) lambda = 0;
  report.forces.tip = lambda.settled;
  last_tip_force_ = report.forces.tip;
  AlongForces forces;
  for (const double weight : tip_weights(mesh)) {
    forces.working.push_back(weight * lambda.working);
    forces.settled.push_back(weight * lambda.settled);
  }
  if (tip_ == TipContact::cut && parameters_.cutting.law == CuttingLaw::lagged) {
    const bool level = velocity_level_;
    velocity_level_ = false;  // the positions as they are
    pending_ = std::max(0.0, gap(mesh, trial));
    velocity_level_ = level;
  }
  report.contact_changes = contact_changes_;
  if (parameters_.friction) {
    const auto lengths = friction_lengths(mesh);
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      auto& shaft = track_.nodes()[i];
      if (!shaft.attached || lengths[i] <= 0) continue;
      const auto& node = trial.at(shaft.node);
      const double relative = v - Axis::along(node.v);
      const bool sticks = shaft.contact == Contact::stick;
      const double slip = shaft.slip_sign * parameters_.friction->kinetic_force * lengths[i];
      const double settled = sticks ? Axis::along(node.settled) : slip;
      report.forces.friction += settled;
      forces.settled[i] += settled;
      forces.working[i] += sticks ? Axis::along(node.working) : slip;
      ++(sticks ? report.n_stick : report.n_slip);
      if (!sticks && std::abs(relative) < parameters_.friction->stick_speed) {
        shaft.contact = Contact::stick;
      }
    }
  }
  book_work(start, trial, forces, end_weight, report);

  // A tip that let go leaves the nodes that it has passed (paper, sec. V.E), and takes them again on
  // its way back in.
  if (tip_ == TipContact::open) {
    const auto s = track_.distances(mesh);
    const auto world = [&](std::size_t i) {
      const int node = track_.nodes()[i].node;
      return Axis::along(displaced(mesh.point(node), trial.at(node).u));
    };
    exposed_ = s.front();
    for (std::size_t i = 0; i < s.size(); ++i) {
      auto& shaft = track_.nodes()[i];
      const bool behind = world(i) <= step_.to;
      if (behind && !shaft.attached && parameters_.friction) {
        const double relative = v - Axis::along(trial.at(shaft.node).v);
        shaft.contact =
            std::abs(relative) > parameters_.friction->slip_speed ? Contact::slip : Contact::stick;
        shaft.slip_sign = relative > 0 ? 1 : -1;
      }
      shaft.attached = behind;
      if (!behind) continue;
      exposed_ = s[i];
      if (i + 1 == s.size()) continue;
      const double gap_to_next = world(i + 1) - world(i);
      if (gap_to_next > 0) {
        const double covered = std::clamp((step_.to - world(i)) / gap_to_next, 0.0, 1.0);
        exposed_ = s[i] - covered * (s[i] - s[i + 1]);
      }
    }
    if (released()) phase_ = NeedlePhase::withdrawn;
  }
  motion_.commit(step_);
  return report;
}

ReferencePoint Needle::tip_point(const Mesh& mesh) const {
  const auto s = track_.distances(mesh);
  for (std::size_t i = 0; i + 1 < s.size(); ++i) {
    if (exposed_ > s[i] || exposed_ < s[i + 1] || s[i] == s[i + 1]) continue;
    const auto a = mesh.point(track_.nodes()[i].node);
    const auto b = mesh.point(track_.nodes()[i + 1].node);
    return a + ((s[i] - exposed_) / (s[i] - s[i + 1])) * (b - a);
  }
  return mesh.point(track_.tip());
}

bool Needle::released() const {
  return std::ranges::none_of(track_.nodes(), &ShaftNode::attached);
}

}  // namespace stylet
