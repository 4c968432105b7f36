#include "stylet/needle/shaft_contacts.hpp"

#include "stylet/needle/friction.hpp"
#include "stylet/needle/slack.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

namespace {

// Contacts change all at once until one of them has changed this often on the same mesh.
constexpr int hasty_changes = 3;
// Then so often without getting fewer.
constexpr int most_patience = 10;
// Rounds of changes in a step, wherever the search has taken the tip; from then on limits of force stand.
constexpr int most_rounds = 60;

}  // namespace

void ShaftContacts::start_step(Track& track) {
  changes_ = 0;
  rounds_ = 0;
  forget_changes(track);
}

void ShaftContacts::forget_changes(Track& track) {
  if (rounds_ <= most_rounds) {
    for (auto& shaft : track.nodes()) shaft.changes = 0;
  }
  forget_block();
}

void ShaftContacts::forget_block() {
  fewest_wrong_ = std::numeric_limits<std::size_t>::max();
  patience_ = most_patience;
}

bool ShaftContacts::is_careful(const Track& track) const {
  return rounds_ > most_rounds || std::ranges::any_of(track.nodes(), [](const ShaftNode& n) {
           return n.changes >= hasty_changes;
         });
}

// Block pivoting: which of them change now.
void ShaftContacts::choose(std::vector<std::size_t>& wrong) {
  if (wrong.size() < fewest_wrong_) {
    fewest_wrong_ = wrong.size();
    patience_ = most_patience;
  } else if (patience_ > 0) {
    --patience_;
  } else {
    wrong = {wrong.back()};
  }
}

ShaftContacts::Verdict ShaftContacts::review(Track& track,
                                             std::span<const double> lengths,
                                             const TrackTrial& trial,
                                             const FrictionParameters& law,
                                             double speed) {
  const bool careful = is_careful(track);
  std::vector<std::size_t> wrong;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const auto& shaft = track.nodes()[i];
    if (!shaft.attached || lengths[i] <= 0) continue;
    const auto& point = trial.at(static_cast<int>(i));
    if (shaft.contact == Contact::stick) {
      const double limit = holding_force(law, lengths[i], careful && shaft.changes > 0);
      if (std::abs(point.reaction.along) > limit * (1 + force_slack)) wrong.push_back(i);
    } else if (drives(law, shaft.slip_sign, speed - point.v.along)) {
      wrong.push_back(i);
    }
  }
  if (wrong.empty()) return Verdict::agree;
  ++rounds_;
  const bool limits_change =
      std::ranges::any_of(wrong, [&](std::size_t i) { return track.nodes()[i].changes == 0; });
  if (limits_change) forget_block();
  const bool another_gap = limits_change || rounds_ <= most_rounds;
  if (careful) choose(wrong);
  for (const std::size_t i : wrong) {
    auto& shaft = track.nodes()[i];
    if (shaft.contact == Contact::stick) {
      shaft.contact = Contact::slip;
      shaft.slip_sign = trial.at(static_cast<int>(i)).reaction.along > 0 ? 1 : -1;
    } else {
      shaft.contact = Contact::stick;
    }
    ++shaft.changes;
  }
  changes_ += static_cast<int>(wrong.size());
  return another_gap ? Verdict::change_gap : Verdict::change;
}

ShaftContacts::Shaft ShaftContacts::commit(Track& track,
                                           std::span<const double> lengths,
                                           const TrackTrial& trial,
                                           const FrictionParameters& law,
                                           double speed,
                                           std::vector<PointForce>& forces) const {
  Shaft sums;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    auto& shaft = track.nodes()[i];
    if (!shaft.attached || lengths[i] <= 0) continue;
    const auto& point = trial.at(static_cast<int>(i));
    const bool sticks = shaft.contact == Contact::stick;
    const double slip = shaft.slip_sign * sliding_force(law, lengths[i]) +
                        viscous_coefficient(law, lengths[i]) * (speed - point.v.along);
    const double settled = sticks ? point.settled.along : slip;
    sums.force += settled;
    PointForce& force = force_on(forces, static_cast<int>(i));
    force.settled_along += settled;
    force.along += sticks ? point.working.along : slip;
    ++(sticks ? sums.n_stick : sums.n_slip);
    if (!sticks && is_caught(law, speed - point.v.along)) shaft.contact = Contact::stick;
  }
  return sums;
}

}  // namespace stylet
