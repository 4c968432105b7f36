#include "stylet/simulation/step.hpp"

#include "stylet/base/errors.hpp"

#include <string>
#include <vector>

namespace stylet {

namespace {

// Solves of one step: contact changes, secant steps and hand-overs. Beyond it the contact cycles.
constexpr int most_passes = 500;

Multiplier multiplier(const Trial& trial) {
  return {trial.needed.lambda, trial.working.lambda, trial.settled.lambda, trial.means};
}

// The tip cuts as far as the needle asks for. True if the mesh changed.
bool edit(Body& body, Needle& needle) {
  bool edited = false;
  while (needle.wants_edit()) {
    const NeedleEdits edits = needle.plan(body.mesh(), body.view(needle.watched(body.mesh())));
    if (edits.empty()) continue;
    body.apply(edits);
    edited = true;
  }
  return edited;
}

// Rounds of edits, solve and review until every contact and the cut agree with the motion. Returns the
// nodes that the needle loads; the step may have become shorter.
std::vector<int> settle(Body& body, Hand& hand, Needle& needle, NeedleStep& step, SubStep& result) {
  const Mesh& mesh = body.mesh();
  for (;;) {
    const bool edited = edit(body, needle);
    // The elements that the edit left bound the very step that it belongs to.
    if (const double stable = body.stable_step(); edited && stable < step.h) {
      step = hand.step(stable);
      needle.shorten_step(step);
      body.begin(step.h);
    }
    std::vector<int> loaded = needle.loaded_nodes(mesh);
    body.watch(loaded);
    const Trial trial = body.attempt(needle.constraints(mesh), edited);
    ++result.passes;
    result.iterations += trial.iterations;
    if (needle.review(mesh, body.view(loaded, trial), multiplier(trial))) return loaded;
    if (result.passes > most_passes) {
      throw NumericalError("the contact of needle '" + needle.parameters().name +
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
  Trial trial;
  if (needle != nullptr && needle->takes_part(step)) {
    needle->start_step(body.mesh(), step);
    body.begin(step.h);
    const auto loaded = settle(body, hand, *needle, step, result);
    trial = body.finish(awaits_rest);
    result.needle = needle->commit(body.mesh(), body.view(loaded), body.view(loaded, trial),
                                   multiplier(trial), body.ledger().end_weight(trial));
  } else {
    body.begin(step.h);
    result.iterations = body.attempt({}, false).iterations;
    result.passes = 1;
    trial = body.finish(true);
    if (needle != nullptr) needle->move_free(step);
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
