// Whether a trial agrees with the needle's laws, and what to try next where it does not.
#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/needle/needle.hpp"
#include "stylet/needle/slack.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

namespace {

// Of the advance of the needle in a step: what a consistent cut leaves open goes to the next step.
constexpr double gap_tolerance = 1e-4;

}  // namespace

bool Needle::review(const TrackTrial& trial, const Multiplier& lambda) {
  return (!parameters_.friction || review_friction(trial)) && review_tip(trial, lambda);
}

bool Needle::review_friction(const TrackTrial& trial) {
  const auto verdict = contacts_.review(path_->track(), path_->shaft_lengths(), trial,
                                        *parameters_.friction, step_.speed());
  if (verdict == ShaftContacts::Verdict::change_gap) forget_search();
  return verdict == ShaftContacts::Verdict::agree;
}

bool Needle::review_tip(const TrackTrial& trial, const Multiplier& lambda) {
  switch (tip_) {
    case TipContact::stick: {
      if (lambda.needed < -slack()) {
        tip_ = TipContact::open;
        return false;
      }
      if (parameters_.cutting.law == CuttingLaw::increment) return true;
      if (lambda.bearing() <= limit() * (1 + force_slack) + slack()) return true;
      if (holds_beyond_) throw_no_solution();
      if (path_->at_membrane()) {
        path_->puncture();
        path_->new_base();
        forget_search();
      }
      tip_ = TipContact::cut;
      return false;
    }
    case TipContact::cut: {
      const double g = gap(trial);
      if (searches()) return cut_further(g);
      if (g >= -tolerance()) return true;
      tip_ = TipContact::stick;
      return false;
    }
    case TipContact::open:
      break;
  }
  if (gap(trial) <= tolerance()) return true;
  tip_ = TipContact::stick;
  path_->cover();
  return false;
}

bool Needle::cut_further(double gap) {
  if (path_->jumps_ahead()) {
    // The first cut goes ahead at once.
    if (gap <= tolerance()) {
      tip_ = TipContact::stick;
    } else {
      path_->begin_cut();
    }
    return false;
  }
  const auto [verdict, to] = search_.next(path_->b(), gap, path_->end(), tolerance());
  switch (verdict) {
    case AdvanceSearch::Verdict::found:
      return true;
    case AdvanceSearch::Verdict::pass: {
      const long long base = path_->base();
      if (path_->pass_end()) tip_ = TipContact::stick;
      if (path_->base() != base) forget_search();
      return false;
    }
    case AdvanceSearch::Verdict::stick:
      tip_ = TipContact::stick;
      holds_beyond_ = to;
      break;
    case AdvanceSearch::Verdict::move:
      break;
  }
  path_->go_to(to);
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

// What holds after every accepted step: an inserting tip stands at its threshold, or it has less and
// holds, or it waits where its path has been cut already.
void Needle::check_tip(const TrackTrial& trial, double lambda) const {
  if (step_.speed() <= 0 || parameters_.cutting.law == CuttingLaw::increment) return;
  constexpr double solver = 10;  // the solution was refined since the review
  const double most = limit();
  const double g = gap(trial);
  const bool stands = tip_ != TipContact::cut || !searches() || std::abs(g) <= solver * tolerance();
  const bool ahead = tip_ != TipContact::open || g <= solver * tolerance();
  const bool below = lambda <= most * (1 + solver * force_slack) + solver * slack();
  if (stands && ahead && below) return;
  throw NumericalError("the tip of needle '" + parameters_.name + "' bears " + exact(lambda) +
                       " N with a threshold of " + exact(most) + " N, and the needle is " +
                       exact(g) + " m ahead of it: the step has no right end");
}

double Needle::tolerance() const {
  return gap_tolerance * std::max(std::abs(step_.to - step_.from), 1e-9);
}

}  // namespace stylet
