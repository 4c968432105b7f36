#include "stylet/simulation/step.hpp"

#include "stylet/base/errors.hpp"

#include <string>
#include <vector>

namespace stylet {

namespace {

// Solves of one step: contact changes, secant steps and hand-overs. Beyond it the contact cycles.
constexpr int most_passes = 500;

Multiplier multiplier(const Trial& trial) {
  return {trial.needed.lambda, trial.working.lambda, trial.settled.lambda};
}

// The tip cuts as far as the needle asks for. True if the mesh changed.
bool edit(Body& body, Needle& needle) {
  bool edited = false;
  while (needle.wants_edit()) {
    const NeedleEdits edits = needle.plan(body.view(needle.watched()));
    if (edits.empty()) continue;
    body.apply(edits);
    edited = true;
  }
  return edited;
}

// The same step from the same start, shorter where it has to be: the elements that an edit left bound the
// very step that it belongs to, and motion that begins asks for half of it. True if it begins anew.
bool shorten(Body& body, Hand& hand, Needle* needle, NeedleStep& step) {
  constexpr double round_off = 1e-6;  // of equal steps to the end of an action
  const double longest = body.stable_step();
  if (step.h <= (1 + round_off) * longest) return false;
  step = hand.step(longest);
  if (needle != nullptr) needle->shorten_step(step);
  body.begin(step.h);
  return true;
}

// Rounds of edits, solve and review until every contact and the cut agree with the motion. Returns the
// points that the needle loads.
std::vector<int> settle(Body& body, Hand& hand, Needle* needle, NeedleStep& step, SubStep& result) {
  std::vector<int> loaded;
  ConstraintSet constraints;
  for (;;) {
    const bool edited = needle != nullptr && edit(body, *needle);
    if (edited) shorten(body, hand, needle, step);
    if (needle != nullptr) {
      loaded = needle->loaded_points();
      body.watch(needle->track_operator(), loaded);
      constraints = body.beside_held(needle->conditions(), needle->track_operator());
    }
    const Trial trial = body.attempt(constraints, edited);
    ++result.passes;
    result.iterations += trial.iterations;
    if (shorten(body, hand, needle, step)) continue;
    if (needle == nullptr ||
        needle->review(body.view(needle->track_operator(), loaded, trial), multiplier(trial))) {
      return loaded;
    }
    if (result.passes > most_passes) {
      throw NumericalError("the contact of needle '" + needle->parameters().name +
                           "' does not settle after " + std::to_string(most_passes) +
                           " solves; take a smaller time.step");
    }
  }
}

}  // namespace

SubStep take_step(Body& body, Hand& hand, Needle* needle, double longest) {
  SubStep result;
  NeedleStep step = hand.step(longest);
  const bool awaits_rest = hand.awaits() == Awaited::rest;
  const double start = body.time();
  Needle* active = needle != nullptr && needle->takes_part(step) ? needle : nullptr;

  if (active != nullptr) active->start_step(step);
  body.begin(step.h);
  const auto loaded = settle(body, hand, active, step, result);
  const Trial trial = body.finish(active == nullptr || awaits_rest);
  if (active != nullptr) {
    const TrackOperator& track = active->track_operator();
    result.needle = active->commit(body.view(track, loaded), body.view(track, loaded, trial),
                                   multiplier(trial), trial.end_weight);
  } else if (needle != nullptr) {
    needle->move_free(step);
  }
  body.accept(trial, result.needle.work, result.needle.dissipated);
  result.h = step.h;

  StepOutcome outcome;
  outcome.withdrawn = needle != nullptr && needle->released();
  outcome.conditions_change = body.conditions_change(start, body.time());
  if (awaits_rest) outcome.largest_speed = body.largest_speed();
  hand.stepped(step, outcome);
  return result;
}

}  // namespace stylet
