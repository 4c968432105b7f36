// The work of the needle on the tissue, point by point.
#pragma once

#include "stylet/needle/motion.hpp"
#include "stylet/needle/view.hpp"

#include <vector>

namespace stylet {

/// Of the needle on a node (N): what does work in a step, and what is left at its end, as in Trial.
struct NodeForce {
  int node;
  double along = 0;
  double across = 0;
  double settled_along = 0;
  double settled_across = 0;
};

/// The entry of a node, made if there is none.
[[nodiscard]] NodeForce& force_on(std::vector<NodeForce>& forces, int node);

class ContactWork {
 public:
  struct Sums {
    double work = 0;        ///< J, done by the hand
    double dissipated = 0;  ///< J of it; the rest went into the tissue
  };
  /// The forces of an accepted step. start: the loaded nodes after the last edits; end_weight: of the
  /// forces at the end of the step in its work, those at its start have the rest.
  Sums book(const NeedleStep& step,
            const NeedleView& start,
            const TrialView& trial,
            std::vector<NodeForce> forces,
            double end_weight);
  /// At the end of the last step.
  [[nodiscard]] const std::vector<NodeForce>& last() const { return last_; }

 private:
  std::vector<NodeForce> last_;
};

}  // namespace stylet
