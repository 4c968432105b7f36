// The hand of a recorded procedure.
#pragma once

#include "stylet/scene/procedure.hpp"
#include "stylet/simulation/hand.hpp"

#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace stylet {

/// Does what the rows say. In steps as they were recorded every number of the simulation has the same
/// bits; where steps have another length, each row takes the same time and goes the same way.
class Recorded : public Hand {
 public:
  explicit Recorded(std::vector<ProcedureRow> rows) : rows_(std::move(rows)) {}

  [[nodiscard]] Wish next() const override;
  [[nodiscard]] NeedleStep step(double longest) override;
  [[nodiscard]] long long ended() const override { return ended_; }
  void entered(double skin, double at_rest) override;
  void implanted() override { obeyed(); }
  void changed() override { obeyed(); }
  /// A limit that was set is in the speeds of the rows.
  [[nodiscard]] std::optional<double> speed_limit() const override {
    return std::numeric_limits<double>::infinity();
  }
  void stepped(const NeedleStep& step, const StepOutcome& outcome) override;

 private:
  void obeyed();

  std::vector<ProcedureRow> rows_;
  std::size_t at_ = 0;
  double elapsed_ = 0;  ///< in this row (s)
  double tip_ = 0;      ///< m
  long long ended_ = 0;
};

}  // namespace stylet
