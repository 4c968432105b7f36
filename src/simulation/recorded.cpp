#include "stylet/simulation/recorded.hpp"

#include <algorithm>

namespace stylet {

namespace {

constexpr double round_off = 1e-9;  // of a step, where rows are cut into steps of other lengths

}  // namespace

Wish Recorded::next() const {
  if (at_ == rows_.size()) return {Wish::Kind::done};
  const ProcedureRow& row = rows_[at_];
  switch (row.kind) {
    case ProcedureRow::Kind::enter:
      return {Wish::Kind::enter, &row.needle};
    case ProcedureRow::Kind::implant:
      return {Wish::Kind::implant, nullptr, row.target};
    case ProcedureRow::Kind::change:
      return {Wish::Kind::change, nullptr, {}, row.key, row.value};
    case ProcedureRow::Kind::move:
    case ProcedureRow::Kind::undo:
      break;
  }
  return {};
}

NeedleStep Recorded::step(double longest) {
  const ProcedureRow& row = rows_[at_];
  const bool fits = elapsed_ + longest <= row.duration + round_off * longest;
  const double h = fits ? longest : row.duration - elapsed_;
  return {h, tip_, tip_ + row.speed * h};
}

void Recorded::entered(double skin, double /*at_rest*/) {
  tip_ = skin;
  obeyed();
}

void Recorded::obeyed() {
  ++at_;
  ++ended_;
}

void Recorded::stepped(const NeedleStep& step, const StepOutcome& /*outcome*/) {
  tip_ = step.to;
  elapsed_ += step.h;
  const ProcedureRow& row = rows_[at_];
  if (row.duration - elapsed_ > round_off * step.h) return;
  elapsed_ = 0;
  ++at_;
  // A row that goes on as the last one did is no new action.
  const bool goes_on = at_ < rows_.size() && rows_[at_].kind == ProcedureRow::Kind::move &&
                       rows_[at_].speed == row.speed;
  if (!goes_on) ++ended_;
}

}  // namespace stylet
