#include "stylet/simulation/recording.hpp"

namespace stylet {

void RecordingHand::entered(double skin, double at_rest) {
  ProcedureRow row{ProcedureRow::Kind::enter};
  row.needle = order().needle;
  LiveHand::entered(skin, at_rest);
  write(row);
}

void RecordingHand::implanted() {
  ProcedureRow row{ProcedureRow::Kind::implant};
  row.target = order().target;
  LiveHand::implanted();
  write(row);
}

void RecordingHand::changed() {
  ProcedureRow row{ProcedureRow::Kind::change};
  row.key = order().key;
  row.value = order().value;
  LiveHand::changed();
  write(row);
}

void RecordingHand::stepped(const NeedleStep& step, const StepOutcome& outcome) {
  LiveHand::stepped(step, outcome);
  if (records_) log_.step(speed(), step.h);
}

}  // namespace stylet
