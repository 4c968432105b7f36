#include "stylet/needle/contact_work.hpp"

#include <algorithm>
#include <utility>

namespace stylet {

PointForce& force_on(std::vector<PointForce>& forces, int point) {
  const auto found = std::ranges::find(forces, point, &PointForce::point);
  return found == forces.end() ? forces.emplace_back(PointForce{point}) : *found;
}

ContactWork::Sums ContactWork::book(const NeedleStep& step,
                                    const TrackStart& start,
                                    const TrackTrial& trial,
                                    std::vector<PointForce> forces,
                                    double end_weight) {
  Sums sums;
  // Forces that have ended worked on the way to the end of the step.
  for (const auto& last : last_) static_cast<void>(force_on(forces, last.point));
  const double hand = step.to - step.from;
  for (const auto& now : forces) {
    const auto found = std::ranges::find(last_, now.point, &PointForce::point);
    const PointForce last = found == last_.end() ? PointForce{now.point} : *found;
    const auto mean = [&](double then, double end) {
      return (1 - end_weight) * then + end_weight * end;
    };
    const double along = mean(last.settled_along, now.along);
    const double across = mean(last.settled_across, now.across);
    const double across_too = mean(last.settled_across_too, now.across_too);
    // The needle guides a point that joins it on to its axis: work too.
    const TrackVector& u0 = start.at(now.point);
    const TrackVector& u1 = trial.at(now.point).u;
    sums.work += along * hand + across * (u1.across - u0.across);
    sums.work += across_too * (u1.across_too - u0.across_too);
    sums.dissipated += along * (hand - (u1.along - u0.along));
  }
  std::erase_if(forces, [](const PointForce& f) {
    return f.settled_along == 0 && f.settled_across == 0 && f.settled_across_too == 0;
  });
  last_ = std::move(forces);
  return sums;
}

}  // namespace stylet
