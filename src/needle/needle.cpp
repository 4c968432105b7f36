#include "stylet/needle/needle.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/base/text.hpp"
#include "stylet/needle/membrane.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace stylet {

namespace {

// Contacts change all at once until one of them has changed this often on the same mesh.
constexpr int hasty_changes = 3;
// Then so often without getting fewer.
constexpr int most_patience = 10;
// Rounds of changes in a step, wherever the search has taken the tip; from then on limits of force stand.
constexpr int most_rounds = 60;
// Flips in a step that only make way for the tip.
constexpr int most_passages = 20;
// Of the advance of the needle in a step: what a consistent cut leaves open goes to the next step.
constexpr double gap_tolerance = 1e-4;
// Relative slack of force thresholds against round-off of the solver.
constexpr double force_slack = 1e-9;

// The entry of a node, made if there is none.
NodeForce& force_on(std::vector<NodeForce>& forces, int node) {
  const auto found = std::ranges::find(forces, node, &NodeForce::node);
  return found == forces.end() ? forces.emplace_back(NodeForce{node}) : *found;
}
// Nearer than this to the end of an earlier cut the tip is there (m).
constexpr double touching = 1e-9;
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
      punctures_(tissue_.earlier.punctures) {}

NeedleEdits Needle::enter(const Mesh& mesh, const Entry& entry, const NeedleView& start) {
  const NodeState state =
      interpolate(entry.fraction, start.at(entry.node), start.at(entry.neighbour));
  track_.push({entry.node});
  skin_along_ = axis_.along(displaced(entry.x, state.u));
  tip_along_ = skin_along_;
  // The entry node slides by at most the edge to its neighbour.
  const double slide = distance(mesh.point(entry.node), entry.x);
  skin_ = Skin(mesh, entry.node, 0.5 * parameters_.cutting.tip_length + slide);
  free_ = tissue_.earlier.free_length(entry.x, Axis::direction(), radius()) > touching;
  NeedleEdits edits;
  if (entry.fraction > 0) edits.moves.push_back({entry.node, entry.x, state});
  return edits;
}

EarlierCuts Needle::leave(const Mesh& mesh) const {
  EarlierCuts cuts = tissue_.earlier;
  cuts.punctures = punctures_;
  if (track_.size() < 2) return cuts;
  auto& path = cuts.paths.emplace_back();
  for (const auto& shaft : track_.nodes()) path.push_back(mesh.point(shaft.node));
  return cuts;
}

std::vector<int> Needle::watched(const Mesh& mesh) const {
  auto nodes = mesh.neighbours(track_.tip());
  for (const auto& shaft : track_.nodes()) nodes.push_back(shaft.node);
  sort_unique(nodes);
  return nodes;
}

std::vector<int> Needle::loaded_nodes(const Mesh& mesh) const {
  std::vector<int> nodes;
  for (const auto& shaft : track_.nodes()) nodes.push_back(shaft.node);
  for (const auto& force : last_forces_) nodes.push_back(force.node);
  if (presses_on_skin(mesh)) {
    nodes.insert(nodes.end(), skin_.nodes().begin(), skin_.nodes().end());
  }
  sort_unique(nodes);
  return nodes;
}

double Needle::path_length(const Mesh& mesh) const {
  return track_.distances(mesh).front();
}

bool Needle::presses_on_skin(const Mesh& mesh) const {
  return path_length(mesh) < parameters_.cutting.tip_length;
}

// Of a tip that is in with all of its length (N).
double Needle::whole_threshold(const Mesh& mesh) const {
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

// Zero where the way is cut already. A tip that is not in with all of its length cuts with that part
// of its force: at the skin the needle begins to cut at once, and how deep it is has a limit on finer
// meshes, at every depth. (A full force on the first bit of path is a point force: the dent that it
// makes grows with the logarithm of the element size, and the tip jumps when the skin gives way.)
double Needle::threshold(const Mesh& mesh) const {
  if (free_) return 0;
  const double tip_length = parameters_.cutting.tip_length;
  const double share = presses_on_skin(mesh) ? path_length(mesh) / tip_length : 1;
  return share * whole_threshold(mesh);
}

// The tip's load is uniform over its length: what is in the tissue loads the path, what is not in yet
// the skin around the entry.
std::vector<NodeShare> Needle::tip_shares(const Mesh& mesh) const {
  const double tip_length = parameters_.cutting.tip_length;
  if (tip_length == 0) return {{track_.tip(), 1}};
  const double zone = std::min(tip_length, path_length(mesh));
  std::vector<NodeShare> shares;
  if (zone < tip_length) shares = skin_.lengths(mesh, tip_length - zone);
  const auto lengths = track_.lengths(mesh, 0, zone);
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (lengths[i] == 0) continue;
    const int node = track_.nodes()[i].node;
    const auto same = std::ranges::find(shares, node, &NodeShare::node);
    if (same == shares.end()) {
      shares.push_back({node, lengths[i]});
    } else {
      same->value += lengths[i];
    }
  }
  double total = 0;
  for (const auto& share : shares) total += share.value;
  for (auto& share : shares) share.value /= total;
  return shares;
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
  const bool keeps_cutting = tip_ == TipContact::cut && step.speed() > 0 && searches();
  remaining_ = keeps_cutting && track_.size() > 1 ? advanced_ : 0;
  advanced_ = 0;
  contact_changes_ = 0;
  rounds_ = 0;
  forget_changes();
  if (tip_ == TipContact::open) return;
  if (parameters_.cutting.law == CuttingLaw::lagged) remaining_ = pending_;
  if (parameters_.cutting.law == CuttingLaw::increment && step.speed() > 0) {
    const double limit = membrane_ ? tissue_.puncture_force : threshold(mesh);
    if (last_tip_force_ >= limit) {
      if (membrane_) puncture();
      remaining_ = parameters_.cutting.increment;
    }
  }
  pending_ = 0;
  if (membrane_) remaining_ = 0;
}

void Needle::puncture() {
  punctures_.push_back(*membrane_);
  membrane_.reset();
  ++counts_.punctures;
}

void Needle::forget_changes() {
  if (rounds_ <= most_rounds) {
    for (auto& shaft : track_.nodes()) shaft.changes = 0;
  }
  forget_block();
}

void Needle::forget_block() {
  fewest_wrong_ = std::numeric_limits<std::size_t>::max();
  patience_ = most_patience;
}

// The next plan looks for the way again, from where the tip then stands.
void Needle::new_base() {
  base_.reset();
  b_ = 0;
  postponed_ = false;
  end_.reset();
  forget_search();
}

void Needle::forget_search() {
  search_.forget();
  holds_beyond_.reset();
}

// The largest b from base_, and what is there.
Needle::End Needle::find_end() const {
  const double reach = postponed_ ? base_->reach : std::min(base_->hand_over, base_->reach);
  End end{std::max(reach, b_), EndKind::hand_over};
  if (free_ && base_free_ < end.b) end = {base_free_, EndKind::virgin};
  const auto membrane = crossing(base_->distance);
  if (membrane && *membrane <= end.b) end = {std::max(*membrane, b_), EndKind::membrane};
  return end;
}

std::optional<double> Needle::crossing(double length) const {
  return first_crossing(tissue_.membrane, base_->p, base_->r, length, punctures_, radius());
}

// The tip has come to the end of its base and wants to go on.
void Needle::pass_end() {
  switch (end_->kind) {
    case EndKind::membrane:
      membrane_ = base_->p + end_->b * base_->r;
      tip_ = TipContact::stick;
      break;
    case EndKind::virgin:
      free_ = false;
      tip_ = TipContact::stick;
      new_base();
      break;
    case EndKind::hand_over:
      hand_over_wanted_ = true;
      break;
  }
}

NeedleEdits Needle::plan(const Mesh& mesh, const NeedleView& start) {
  NeedleEdits edits;
  forget_changes();
  const int tip = track_.tip();
  const auto stuck = [&](const std::string& why) {
    return NumericalError("needle '" + parameters_.name + "' cannot advance, " +
                          ten_digits(tip_along_ - skin_along_) +
                          " m behind its entry point: " + why);
  };
  if (!base_) {
    base_ = find_way(mesh, track_, axis_, start);
    if (!base_) throw stuck("its tip has reached the boundary of the tissue");
    if (base_->fell_back) ++counts_.fallbacks;
    base_free_ = tissue_.earlier.free_length(base_->p, base_->r, radius());
    const bool was_free = std::exchange(free_, base_free_ > touching);
    if (was_free && !free_ && !hand_over_wanted_) {
      // It has come to the end of the earlier cut.
      tip_ = TipContact::stick;
      remaining_ = 0;
      return edits;
    }
  }
  // The first cut goes half-way to the edge ahead at once; a membrane in its way is met at the skin.
  const double first_cut = 0.5 * base_->distance;
  if (track_.size() == 1) {
    if (const auto met = crossing(first_cut)) {
      membrane_ = base_->p + *met * base_->r;
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
      end_ = find_end();
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
  end_ = find_end();
  double to = std::max(0.0, b_ + remaining_);
  remaining_ = 0;
  if (to >= end_->b) {
    // A search goes on from there when it has seen the gap; the other laws know how far they go.
    const double left = to - end_->b;
    to = end_->b;
    if (!searches()) {
      if (end_->kind == EndKind::hand_over) remaining_ = left;
      pass_end();
    }
  }
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
  const double f = threshold(mesh);
  MeanCondition mean;
  for (const auto& [node, share] : tip_shares(mesh)) {
    const int dof = Axis::along_dof(node);
    mean.weights.push_back({dof, Axis::along_sign * share});
    if (tip_ == TipContact::cut && f > 0) {
      set.forces.push_back({dof, Axis::along_sign * f * share});
    }
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
  double mean_u = 0;
  double mean_v = 0;
  for (const auto& [node, share] : tip_shares(mesh)) {
    mean_u += share * Axis::along(trial.at(node).u);
    mean_v += share * Axis::along(trial.at(node).v);
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
  if (parameters_.friction && !review_friction(mesh, trial)) return false;
  return review_tip(mesh, trial, lambda);
}

// All contacts change at once where they must, which is fast and may cycle. So on a mesh that has not
// changed for long, nodes that have slid have one limit of force for sticking and sliding: that is
// Tresca's problem, which has one solution, and block pivoting finds it (Portugal, Judice and Vicente
// 1994): all that must change as long as they get fewer, else the last one alone.
// A search moves the tip and begins this anew. After many rounds the nodes that have slid keep their one
// limit for the rest of the step, and can only become more: for each set of them the gap is a continuous
// function of the advance, which the search does not forget any more and brackets in finitely many steps.
bool Needle::review_friction(const Mesh& mesh, const TrialView& trial) {
  const auto lengths = friction_lengths(mesh);
  const auto& friction = *parameters_.friction;
  const bool careful =
      rounds_ > most_rounds || std::ranges::any_of(track_.nodes(), [](const ShaftNode& n) {
        return n.changes >= hasty_changes;
      });
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
      // A sign that contradicts the new velocity turns into stick (src/MODEL.md, section 6).
      const double relative = step_.speed() - Axis::along(node.v);
      const double noise = 1e-9 * friction.stick_speed;
      if (shaft.slip_sign * relative < -noise) wrong.push_back(i);
    }
  }
  if (wrong.empty()) return true;
  ++rounds_;
  const bool limits_change =
      std::ranges::any_of(wrong, [&](std::size_t i) { return track_.nodes()[i].changes == 0; });
  if (limits_change) forget_block();
  if (limits_change || rounds_ <= most_rounds) forget_search();  // another gap
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
  switch (tip_) {
    case TipContact::stick: {
      if (lambda.needed < -slack()) {
        tip_ = TipContact::open;
        return false;
      }
      if (parameters_.cutting.law == CuttingLaw::increment) return true;
      const double limit = membrane_ ? tissue_.puncture_force : threshold(mesh);
      if (lambda.bearing() <= limit * (1 + force_slack) + slack()) return true;
      if (holds_beyond_) throw_no_solution();
      if (membrane_) {
        puncture();
        new_base();
      }
      tip_ = TipContact::cut;
      return false;
    }
    case TipContact::cut: {
      const double g = gap(mesh, trial);
      if (searches()) return cut_further(g);
      if (g >= -tolerance()) return true;
      tip_ = TipContact::stick;
      return false;
    }
    case TipContact::open:
      break;
  }
  if (gap(mesh, trial) <= tolerance()) return true;
  tip_ = TipContact::stick;
  exposed_ = 0;
  for (auto& shaft : track_.nodes()) {
    if (shaft.attached) continue;
    shaft.attached = true;
    shaft.contact = Contact::stick;
  }
  return false;
}

bool Needle::cut_further(double gap) {
  if (track_.size() == 1) {
    // The first cut goes ahead at once.
    if (gap <= tolerance()) {
      tip_ = TipContact::stick;
    } else {
      hand_over_wanted_ = true;
    }
    return false;
  }
  const auto end = end_ ? std::optional(end_->b) : std::nullopt;
  const auto [verdict, to] = search_.next(b_, gap, end, tolerance());
  switch (verdict) {
    case AdvanceSearch::Verdict::found:
      return true;
    case AdvanceSearch::Verdict::pass:
      pass_end();
      return false;
    case AdvanceSearch::Verdict::stick:
      tip_ = TipContact::stick;
      holds_beyond_ = to;
      break;
    case AdvanceSearch::Verdict::move:
      break;
  }
  remaining_ = to - b_;
  return false;
}

void Needle::throw_no_solution() const {
  const auto& low = search_.too_short();
  const auto& high = search_.too_far();
  throw NumericalError(
      "the advance of needle '" + parameters_.name + "' has no solution: " + exact(*holds_beyond_) +
      " m leave a gap that jumps" + (low ? " from " + exact(low->g) + " m" : "") +
      (high ? " to " + exact(high->g) + " m" : "") + " (allowed: " + exact(gap_tolerance) +
      " of the step); take another time.step or mesh");
}

void Needle::book_work(const NeedleView& start,
                       const TrialView& trial,
                       std::vector<NodeForce> forces,
                       double end_weight,
                       NeedleStepReport& report) {
  for (const auto& shaft : track_.nodes()) {
    if (!shaft.attached) continue;
    NodeForce& force = force_on(forces, shaft.node);
    force.across = Axis::across(trial.at(shaft.node).working);
    force.settled_across = Axis::across(trial.at(shaft.node).settled);
  }
  // Forces that have ended worked on the way to the end of the step.
  for (const auto& last : last_forces_) force_on(forces, last.node);
  const double hand = step_.to - step_.from;
  for (const auto& now : forces) {
    const auto found = std::ranges::find(last_forces_, now.node, &NodeForce::node);
    const NodeForce last = found == last_forces_.end() ? NodeForce{now.node} : *found;
    const auto mean = [&](double then, double end) {
      return (1 - end_weight) * then + end_weight * end;
    };
    const double along = mean(last.settled_along, now.along);
    const double across = mean(last.settled_across, now.across);
    // The needle guides a node that joins it on to its axis: work too.
    const Vector2 moved = trial.at(now.node).u - start.at(now.node).u;
    report.work += along * hand + across * Axis::across(moved);
    report.dissipated += along * (hand - Axis::along(moved));
  }
  std::erase_if(forces,
                [](const NodeForce& f) { return f.settled_along == 0 && f.settled_across == 0; });
  last_forces_ = std::move(forces);
}

// What holds after every accepted step: an inserting tip stands at its threshold, or it has less and
// holds, or it waits where its path has been cut already.
void Needle::check_tip(const Mesh& mesh, const TrialView& trial, double lambda) const {
  if (step_.speed() <= 0 || parameters_.cutting.law == CuttingLaw::increment) return;
  constexpr double solver = 10;  // the solution was refined since the review
  const double limit = membrane_ ? tissue_.puncture_force : threshold(mesh);
  const double g = gap(mesh, trial);
  const bool stands = tip_ != TipContact::cut || !searches() || std::abs(g) <= solver * tolerance();
  const bool ahead = tip_ != TipContact::open || g <= solver * tolerance();
  const bool below = lambda <= limit * (1 + solver * force_slack) + solver * slack();
  if (stands && ahead && below) return;
  throw NumericalError("the tip of needle '" + parameters_.name + "' bears " + exact(lambda) +
                       " N with a threshold of " + exact(limit) + " N, and the needle is " +
                       exact(g) + " m ahead of it: the step has no right end");
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
  check_tip(mesh, trial, lambda.bearing());
  std::vector<NodeForce> forces;
  for (const auto& [node, share] : tip_shares(mesh)) {
    NodeForce& force = force_on(forces, node);
    force.along = share * lambda.working;
    force.settled_along = share * lambda.settled;
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
      NodeForce& on_node = force_on(forces, shaft.node);
      on_node.settled_along += settled;
      on_node.along += sticks ? Axis::along(node.working) : slip;
      ++(sticks ? report.n_stick : report.n_slip);
      if (!sticks && std::abs(relative) < parameters_.friction->stick_speed) {
        shaft.contact = Contact::stick;
      }
    }
  }
  book_work(start, trial, std::move(forces), end_weight, report);

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
  tip_along_ = step_.to;
  return report;
}

TipStand Needle::stand(const Mesh& mesh) const {
  const auto around = mesh.cells_around(track_.tip());
  double size = 0;
  for (const int c : around) size += std::sqrt(2 * mesh.cell_measure(c));
  return {pending_, last_tip_force_, force_to_cut(mesh), size / static_cast<double>(around.size())};
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

double Needle::tolerance() const {
  return gap_tolerance * std::max(std::abs(step_.to - step_.from), 1e-9);
}

double Needle::slack() const {
  return force_slack * parameters_.cutting.cutting_force / parameters_.cutting.sharpness;
}

bool Needle::released() const {
  return std::ranges::none_of(track_.nodes(), &ShaftNode::attached);
}

}  // namespace stylet
