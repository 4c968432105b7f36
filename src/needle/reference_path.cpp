#include "stylet/needle/reference_path.hpp"

#include "stylet/needle/friction.hpp"

#include <algorithm>

namespace stylet {

void ReferencePath::change(double puncture_force, std::vector<double> region_modulus) {
  tissue_.puncture_force = puncture_force;
  tissue_.region_modulus = std::move(region_modulus);
}

double ReferencePath::share_in() const {
  const double in = length();
  return in < tip_length_ ? in / tip_length_ : 1;
}

void ReferencePath::attach(ShaftNode& shaft,
                           bool attached,
                           const PointTrial& trial,
                           const std::optional<FrictionParameters>& friction,
                           double speed) {
  if (attached && !shaft.attached && friction) {
    const double relative = speed - trial.v.along;
    shaft.contact = slides_at_once(*friction, relative) ? Contact::slip : Contact::stick;
    shaft.slip_sign = relative > 0 ? 1 : -1;
  }
  shaft.attached = attached;
}

void ReferencePath::cover() {
  exposed_ = 0;
  for (auto& shaft : track_.nodes()) {
    if (shaft.attached) continue;
    shaft.attached = true;
    shaft.contact = Contact::stick;
  }
}

bool ReferencePath::is_released() const {
  return std::ranges::none_of(track_.nodes(), &ShaftNode::attached);
}

EarlierCuts ReferencePath::leave() const {
  EarlierCuts cuts = tissue_.earlier;
  cuts.punctures = punctures_;
  if (!is_uncut()) cuts.paths.push_back(line());
  return cuts;
}

NeedleEdits ReferencePath::enter(const Entry&, const NeedleView&) {
  throw std::logic_error("a track in space lies where it was made");
}

void ReferencePath::start_step(double advance) {
  new_base();
  advanced_ = 0;
  remaining_ = advance;
}

void ReferencePath::puncture_at(const ReferencePlace& x) {
  punctures_.push_back(x);
  ++counts_.punctures;
}

void ReferencePath::carry_out(const std::function<void(double)>& go, Plan& plan) {
  const double wanted = std::max(0.0, b_ + remaining_);
  const double to = std::min(wanted, end_->b);
  remaining_ = 0;
  if (to != b_) {
    advanced_ += to - b_;
    b_ = to;
    go(to);
  }
  // A search goes on from the end when it has seen the gap; the other laws know how far they go.
  if (wanted >= end_->b && !stops_at_ends_) {
    if (end_->kind == EndKind::hand_over) remaining_ = wanted - end_->b;
    plan.holds = pass_end();
  }
}

}  // namespace stylet
