// What a plan may change of a needle.
#pragma once

#include "stylet/scene/scene.hpp"
#include "stylet/study/plan.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace stylet {

/// Shifts of one needle's stops before implants and of its way across, in millimetres, and the speed of its
/// inserts as a share of its range. Across: its height; in space its axis, in both directions, and where it has
/// more than one stop also its far end alone.
class PlanVariables {
 public:
  using Values = std::vector<double>;
  static constexpr double unit = 1e-3;  ///< m

  /// The options are lent.
  PlanVariables(const Scene& scene, std::size_t needle, const PlanOptions& options);

  [[nodiscard]] std::size_t size() const {
    return stops_.size() + n_across_ + (options_.speeds ? 1 : 0);
  }
  [[nodiscard]] bool empty() const { return stops_.empty(); }
  [[nodiscard]] Values start() const;
  /// sign: -1 for the lower ones, 1 for the upper ones.
  [[nodiscard]] Values bounds(double sign) const;
  /// The variables that stand at an end of their range.
  [[nodiscard]] std::vector<std::string> at_ends(const Values& values) const;
  void apply(const Values& values, Scene& scene) const;

 private:
  static constexpr double speed_scale = 10;  // like millimetres for the trust region

  void shift(NeedleParameters& needle, const double* across) const;

  std::size_t needle_;
  const PlanOptions& options_;
  std::vector<std::size_t> stops_;
  std::size_t n_across_ = 0;
  double start_speed_ = 0;
};

}  // namespace stylet
