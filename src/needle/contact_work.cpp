#include "stylet/needle/contact_work.hpp"

#include "stylet/needle/axis.hpp"

#include <algorithm>
#include <utility>

namespace stylet {

NodeForce& force_on(std::vector<NodeForce>& forces, int node) {
  const auto found = std::ranges::find(forces, node, &NodeForce::node);
  return found == forces.end() ? forces.emplace_back(NodeForce{node}) : *found;
}

ContactWork::Sums ContactWork::book(const NeedleStep& step,
                                    const NeedleView& start,
                                    const TrialView& trial,
                                    std::vector<NodeForce> forces,
                                    double end_weight) {
  Sums sums;
  // Forces that have ended worked on the way to the end of the step.
  for (const auto& last : last_) static_cast<void>(force_on(forces, last.node));
  const double hand = step.to - step.from;
  for (const auto& now : forces) {
    const auto found = std::ranges::find(last_, now.node, &NodeForce::node);
    const NodeForce last = found == last_.end() ? NodeForce{now.node} : *found;
    const auto mean = [&](double then, double end) {
      return (1 - end_weight) * then + end_weight * end;
    };
    const double along = mean(last.settled_along, now.along);
    const double across = mean(last.settled_across, now.across);
    // The needle guides a node that joins it on to its axis: work too.
    const Vector2 moved = trial.at(now.node).u - start.at(now.node).u;
    sums.work += along * hand + across * Axis::across(moved);
    sums.dissipated += along * (hand - Axis::along(moved));
  }
  std::erase_if(forces,
                [](const NodeForce& f) { return f.settled_along == 0 && f.settled_across == 0; });
  last_ = std::move(forces);
  return sums;
}

}  // namespace stylet
