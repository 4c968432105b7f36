// The work of the needle on the tissue, point by point.
#pragma once

#include "stylet/needle/motion.hpp"
#include "stylet/needle/track_view.hpp"

#include <vector>

namespace stylet {

/// Of the needle on a point (N): what does work in a step, and what is left at its end, as in Trial.
struct PointForce {
  int point;
  double along = 0;
  double across = 0;
  double settled_along = 0;
  double settled_across = 0;
  double across_too = 0;  ///< in space
  double settled_across_too = 0;
};

/// The entry of a point, made if there is none.
[[nodiscard]] PointForce& force_on(std::vector<PointForce>& forces, int point);

class ContactWork {
 public:
  struct Sums {
    double work = 0;        ///< J, done by the hand
    double dissipated = 0;  ///< J of it; the rest went into the tissue
  };
  /// The forces of an accepted step. start: the loaded points after the last edits; end_weight: of the
  /// forces at the end of the step in its work, those at its start have the rest.
  Sums book(const NeedleStep& step,
            const TrackStart& start,
            const TrackTrial& trial,
            std::vector<PointForce> forces,
            double end_weight);
  /// At the end of the last step.
  [[nodiscard]] const std::vector<PointForce>& last() const { return last_; }
  void archive(Archive& archive);

 private:
  std::vector<PointForce> last_;
};

}  // namespace stylet
