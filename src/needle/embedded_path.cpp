#include "stylet/needle/embedded_path.hpp"

#include "stylet/mesh/embedded_point.hpp"
#include "stylet/needle/surface_crossings.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace stylet {

EmbeddedPath::EmbeddedPath(const Mesh& mesh,
                           EmbeddedTrack track,
                           double tip_length,
                           double radius,
                           bool stops_at_ends,
                           NeedleTissue tissue)
    : ReferencePath(tip_length, radius, stops_at_ends, std::move(tissue)),
      mesh_(mesh),
      way_(std::move(track)),
      crossings_(surface_crossings(tissue_.membrane_surface,
                                   way_.skin(),
                                   way_.direction(Component::along),
                                   way_.segment(way_.size() - 1).to)) {
  track_.push({-1});
  free_ = tissue_.earlier.free_length(way_.skin(), way_.direction(Component::along), radius_) >
          touching;
  stand();
}

WorldPlace EmbeddedPath::on_axis(double along) const {
  const ReferencePlace x = way_.at(along);
  return {x.x, x.y, x.z};
}

std::vector<ReferencePlace> EmbeddedPath::line() const {
  return {way_.skin(), way_.at(length())};
}

double EmbeddedPath::modulus_ahead() const {
  return tissue_.region_modulus[static_cast<std::size_t>(mesh_.region(cell_))];
}

double EmbeddedPath::element_size() const {
  return std::cbrt(6 * mesh_.cell_measure(cell_));
}

// The tip's load is uniform over what of it is in the tissue.
std::vector<PointShare> EmbeddedPath::tip_shares() const {
  if (is_uncut()) return {{0, 1}};
  return way_.shares(std::max(0.0, length() - tip_length_), length());
}

std::vector<double> EmbeddedPath::shaft_lengths() const {
  const double end = length() - exposed_ - tip_length_;
  std::vector<double> lengths;
  for (int i = 0; i <= last(); ++i) {
    const auto& segment = way_.segment(i);
    lengths.push_back(std::max(0.0, std::min(end, segment.to) - segment.from));
  }
  return lengths;
}

std::vector<int> EmbeddedPath::loaded_points() const {
  std::vector<int> points(track_.size());
  std::iota(points.begin(), points.end(), 0);
  return points;
}

void EmbeddedPath::guide(int point, std::vector<TrackHold>& held) const {
  held.push_back({{point, Component::across}, 0});
  held.push_back({{point, Component::across_too}, 0});
}

// The depth s to which the needle's tip has come back: s + u(s) = to, u linear between the middles of
// segments.
void EmbeddedPath::uncover(double to,
                           const TrackTrial& trial,
                           const std::optional<FrictionParameters>& friction,
                           double speed) {
  const auto moved = [&](int i) { return trial.at(i).u.along; };
  const auto middle = [&](int i) {
    return std::min(length(), (way_.segment(i).from + way_.segment(i).to) / 2);
  };
  double depth = std::clamp(to - moved(last()), middle(last()), length());
  if (to - moved(last()) < middle(last())) {
    depth = 0;
    for (int i = last(); i-- > 0;) {
      const double here = middle(i) + moved(i);
      if (here > to) continue;
      const double next = middle(i + 1) + moved(i + 1);
      depth = middle(i) + (to - here) / (next - here) * (middle(i + 1) - middle(i));
      break;
    }
    if (depth == 0) depth = std::clamp(to - moved(0), 0.0, middle(0));
  }
  exposed_ = length() - depth;
  for (int i = 0; i <= last(); ++i) {
    attach(track_.nodes()[static_cast<std::size_t>(i)], way_.segment(i).from < depth, trial.at(i),
           friction, speed);
  }
}

// True if the tip has come to the end of an earlier cut, and waits.
bool EmbeddedPath::find_base() {
  const ReferencePlace tip = way_.at(base_);
  const double free = tissue_.earlier.free_length(tip, way_.direction(Component::along), radius_);
  const bool was_free = std::exchange(free_, free > touching);
  const bool is_last = last() + 1 == way_.size();
  end_ = End{way_.segment(last()).to - base_, is_last ? EndKind::track : EndKind::hand_over};
  if (free_ && free < end_->b) end_ = {free, EndKind::virgin};
  for (const double depth : crossings_) {
    if (depth < base_ || is_near(punctures_, way_.at(depth), radius_)) continue;
    if (depth - base_ <= end_->b) end_ = {depth - base_, EndKind::membrane};
    break;
  }
  return was_free && !free_;
}

bool EmbeddedPath::pass_end() {
  switch (end_->kind) {
    case EndKind::membrane:
      membrane_ = base_ + end_->b;
      return true;
    case EndKind::virgin:
      free_ = false;
      new_base();
      return true;
    case EndKind::track:
      leaves_ = true;
      return false;
    case EndKind::hand_over:
      break;
  }
  const ShaftNode& tip = track_.nodes().back();
  track_.push({-1, true, tip.contact, tip.slip_sign, 0});
  ++counts_.hand_overs;
  new_base();
  base_ = way_.segment(last()).from;  // to the last bit
  return false;
}

void EmbeddedPath::puncture() {
  puncture_at(way_.at(*membrane_));
  membrane_.reset();
}

void EmbeddedPath::new_base() {
  base_ += b_;
  b_ = 0;
  end_.reset();
  ++n_bases_;
}

void EmbeddedPath::stand() {
  const double from = std::max(0.0, length() - tip_length_);
  rest_ = is_uncut() ? 0 : way_.rest_of_ends(from, length());
  if (const auto found = locate(mesh_, way_.at(length()), way_.cell(last()))) cell_ = found->cell;
}

EmbeddedPath::Plan EmbeddedPath::plan(const NeedleView&) {
  if (leaves_)
    throw Blocked("its tip has cut deeper than the needle ever goes, by all of its length");
  Plan plan;
  if (!end_ && find_base()) {
    remaining_ = 0;
    plan.holds = true;
    return plan;
  }
  carry_out([this](double) { stand(); }, plan);
  return plan;
}

}  // namespace stylet
