#include "stylet/needle/cut_path.hpp"

#include "stylet/base/sorted.hpp"
#include "stylet/needle/membrane.hpp"
#include "stylet/needle/quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace stylet {

namespace {

// Flips in a step that only make way for the tip.
constexpr int most_passages = 20;
// A poor hand-over waits until the tip has come closer by this share of the distance to the edge ahead.
constexpr double closer = 0.02;
// The first cut goes so far to the edge ahead at once.
constexpr double first_cut = 0.5;

}  // namespace

CutPath::CutPath(const Mesh& mesh,
                 Axis axis,
                 double tip_length,
                 double radius,
                 bool stops_at_ends,
                 NeedleTissue tissue)
    : ReferencePath(tip_length, radius, stops_at_ends, std::move(tissue)),
      mesh_(mesh),
      axis_(axis) {}

NeedleEdits CutPath::enter(const Entry& entry, const NeedleView& start) {
  const NodeState state =
      interpolate(entry.fraction, start.at(entry.node), start.at(entry.neighbour));
  track_.push({entry.node});
  // The entry node slides by at most the edge to its neighbour.
  const double slide = distance(mesh_.point(entry.node), entry.x);
  skin_ = Skin(mesh_, entry.node, 0.5 * tip_length_ + slide);
  free_ = tissue_.earlier.free_length(entry.x, in_space(Axis::direction()), radius_) > touching;
  NeedleEdits edits;
  if (entry.fraction > 0) edits.moves.push_back({entry.node, entry.x, state});
  return edits;
}

std::vector<ReferencePlace> CutPath::line() const {
  std::vector<ReferencePlace> line;
  for (const auto& shaft : track_.nodes()) line.push_back(mesh_.point(shaft.node));
  return line;
}

void CutPath::guide(int point, std::vector<TrackHold>& held) const {
  const double from_axis =
      axis_.across_position - Axis::across(this->point(static_cast<std::size_t>(point)));
  held.push_back({{point, Component::across}, from_axis});
}

std::vector<int> CutPath::watched() const {
  auto nodes = mesh_.neighbours(track_.tip());
  for (const auto& shaft : track_.nodes()) nodes.push_back(shaft.node);
  sort_unique(nodes);
  return nodes;
}

std::vector<int> CutPath::loaded_points() const {
  std::vector<int> points(track_.size());
  std::iota(points.begin(), points.end(), 0);
  if (length() < tip_length_) {
    for (const int node : skin_.nodes()) points.push_back(skin_point(node));
  }
  return points;
}

int CutPath::skin_point(int node) const {
  if (node == track_.nodes().front().node) return 0;
  return static_cast<int>(skin_.nodes().begin() - std::ranges::find(skin_.nodes(), node)) - 1;
}

std::optional<DofValue> CutPath::dof(TrackPlace place) const {
  const auto i = static_cast<std::size_t>(place.point < 0 ? -place.point - 1 : place.point);
  const int node = place.point < 0 ? skin_.nodes()[i] : track_.nodes()[i].node;
  if (place.component == Component::along) return DofValue{Axis::along_dof(node), Axis::along_sign};
  return DofValue{Axis::across_dof(node), 1.0};
}

double CutPath::modulus_ahead() const {
  int ahead = -1;
  double furthest = -std::numeric_limits<double>::infinity();
  for (const int c : mesh_.cells_around(track_.tip())) {
    double along = 0;
    for (const int node : mesh_.cell(c)) along += Axis::along(mesh_.point(node)) / 3;
    if (along > furthest) {
      furthest = along;
      ahead = c;
    }
  }
  return tissue_.region_modulus[static_cast<std::size_t>(mesh_.region(ahead))];
}

double CutPath::element_size() const {
  const auto around = mesh_.cells_around(track_.tip());
  double size = 0;
  for (const int c : around) size += std::sqrt(2 * mesh_.cell_measure(c));
  return size / static_cast<double>(around.size());
}

// The tip's load is uniform over its length: what is in the tissue loads the path, what is not in yet
// the skin around the entry.
std::vector<PointShare> CutPath::tip_shares() const {
  if (tip_length_ == 0) return {{static_cast<int>(track_.size()) - 1, 1}};
  const double zone = std::min(tip_length_, length());
  std::vector<PointShare> shares;
  if (zone < tip_length_) {
    for (const auto& [node, value] : skin_.lengths(mesh_, tip_length_ - zone)) {
      shares.push_back({skin_point(node), value});
    }
  }
  const auto lengths = track_.lengths(mesh_, 0, zone);
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (lengths[i] == 0) continue;
    const int point = static_cast<int>(i);
    const auto same = std::ranges::find(shares, point, &PointShare::point);
    if (same == shares.end()) {
      shares.push_back({point, lengths[i]});
    } else {
      same->value += lengths[i];
    }
  }
  double total = 0;
  for (const auto& share : shares) total += share.value;
  for (auto& share : shares) share.value /= total;
  return shares;
}

std::vector<double> CutPath::shaft_lengths() const {
  auto lengths = track_.lengths(mesh_, exposed_ + tip_length_, length());
  if (lengths.size() > 1) {
    // The tip node obeys the tip's law alone; the shaft that it stands for goes to its neighbour, also
    // where the tip is open: a force that came and went with the contact would let it cycle.
    lengths[lengths.size() - 2] += lengths.back();
    lengths.back() = 0;
  }
  return lengths;
}

void CutPath::uncover(double to,
                      const TrackTrial& trial,
                      const std::optional<FrictionParameters>& friction,
                      double speed) {
  const auto s = track_.distances(mesh_);
  const auto world = [&](std::size_t i) {
    return Axis::along(point(i)) + trial.at(static_cast<int>(i)).u.along;
  };
  exposed_ = s.front();
  for (std::size_t i = 0; i < s.size(); ++i) {
    auto& shaft = track_.nodes()[i];
    const bool behind = world(i) <= to;
    attach(shaft, behind, trial.at(static_cast<int>(i)), friction, speed);
    if (!behind) continue;
    exposed_ = s[i];
    if (i + 1 == s.size()) continue;
    const double gap_to_next = world(i + 1) - world(i);
    if (gap_to_next > 0) {
      const double covered = std::clamp((to - world(i)) / gap_to_next, 0.0, 1.0);
      exposed_ = s[i] - covered * (s[i] - s[i + 1]);
    }
  }
}

ReferencePlace CutPath::tip_point() const {
  const auto s = track_.distances(mesh_);
  for (std::size_t i = 0; i + 1 < s.size(); ++i) {
    if (exposed_ > s[i] || exposed_ < s[i + 1] || s[i] == s[i + 1]) continue;
    return point(i) + ((s[i] - exposed_) / (s[i] - s[i + 1])) * (point(i + 1) - point(i));
  }
  return tip();
}

void CutPath::start_step(double advance) {
  ReferencePath::start_step(advance);
  passages_ = 0;
}

void CutPath::new_base() {
  base_.reset();
  ++n_bases_;
  b_ = 0;
  postponed_ = false;
  end_.reset();
}

// The largest b from base_, and what is there.
CutPath::End CutPath::find_end() const {
  const double reach = postponed_ ? base_->reach : std::min(base_->hand_over, base_->reach);
  End end{std::max(reach, b_), EndKind::hand_over};
  if (free_ && base_free_ < end.b) end = {base_free_, EndKind::virgin};
  const auto membrane = crossing(base_->distance);
  if (membrane && *membrane <= end.b) end = {std::max(*membrane, b_), EndKind::membrane};
  return end;
}

std::optional<double> CutPath::crossing(double length) const {
  return first_crossing(tissue_.membrane, base_->p, base_->r, length, punctures_, radius_);
}

void CutPath::puncture() {
  puncture_at(*membrane_);
  membrane_.reset();
}

bool CutPath::pass_end() {
  switch (end_->kind) {
    case EndKind::membrane:
      membrane_ = base_->p + end_->b * base_->r;
      return true;
    case EndKind::virgin:
      free_ = false;
      new_base();
      return true;
    case EndKind::hand_over:
    case EndKind::track:  // of space only
      break;
  }
  hand_over_wanted_ = true;
  return false;
}

// True if the tip has come to the end of an earlier cut, and waits.
bool CutPath::find_base(const NeedleView& start) {
  base_ = find_way(mesh_, track_, axis_, start);
  if (!base_) throw Blocked("its tip has reached the boundary of the tissue");
  if (base_->fell_back) ++counts_.fallbacks;
  base_free_ = tissue_.earlier.free_length(base_->p, in_space(base_->r), radius_);
  const bool was_free = std::exchange(free_, base_free_ > touching);
  return was_free && !free_ && !hand_over_wanted_;
}

CutPath::Plan CutPath::hand_over(const NeedleView& start) {
  auto hand_over = plan_hand_over(mesh_, track_, *base_, start);
  const double quality = hand_over ? hand_over->quality : 0;
  hand_over_wanted_ = false;
  if (quality < fair_quality && !is_uncut() && base_->reach > b_ + closer * base_->distance) {
    postponed_ = true;
    end_ = find_end();
    return {};
  }
  if (quality < least_quality) {
    // Other nodes come within reach if an edge is flipped.
    const auto passage = plan_passage(mesh_, track_, *base_);
    if (!passage || ++passages_ > most_passages) {
      throw Blocked(
          "no node near its tip can become the next one (they are held, or an element would "
          "become too thin); refine the mesh or move the needle");
    }
    new_base();
    Plan flip;
    flip.edits.flips.push_back(*passage);
    return flip;
  }
  if (is_uncut()) {
    const double cut = first_cut * base_->distance;
    remaining_ = std::max(0.0, remaining_ - cut);
    advanced_ += cut;
  }
  const Contact inherited = track_.nodes().back().contact;
  track_.push({hand_over->new_tip, true, inherited, track_.nodes().back().slip_sign, 0});
  ++counts_.hand_overs;
  new_base();
  return {std::move(hand_over->edits)};
}

CutPath::Plan CutPath::plan(const NeedleView& start) {
  Plan plan;
  if (!base_ && find_base(start)) {
    remaining_ = 0;
    plan.holds = true;
    return plan;
  }
  if (is_uncut()) {
    // A membrane in the way of the first cut is met at the skin.
    if (const auto met = crossing(first_cut * base_->distance)) {
      membrane_ = base_->p + *met * base_->r;
      hand_over_wanted_ = false;
      remaining_ = 0;
      plan.holds = true;
      return plan;
    }
  }
  if (hand_over_wanted_ || is_uncut()) return hand_over(start);
  end_ = find_end();
  carry_out(
      [&](double b) { plan.edits.moves.push_back(stylet::advanced(*base_, track_.tip(), b)); },
      plan);
  return plan;
}

}  // namespace stylet
