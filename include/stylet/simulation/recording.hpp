// What a hand does while the program runs, as a scene that runs again.
#pragma once

#include "stylet/scene/procedure.hpp"
#include "stylet/simulation/hand.hpp"
#include "stylet/simulation/procedure_log.hpp"

#include <cstddef>
#include <string>

namespace stylet {

/// A live hand that writes down what became of its orders, and every step. Throws IoError, from
/// `Simulation::step`, where the log cannot be written.
class RecordingHand : public LiveHand {
 public:
  /// The log outlives the hand.
  explicit RecordingHand(ProcedureLog& log) : log_(log) {}

  void entered(double skin, double at_rest) override;
  void implanted() override;
  void changed() override;
  void stepped(const NeedleStep& step, const StepOutcome& outcome) override;

  /// How far the log has got; belongs to the state of the simulation now, between two steps.
  [[nodiscard]] std::size_t mark() { return log_.mark(); }
  /// The simulation, and this hand (`hold_at`), went back to that state: a replay leaves out what came
  /// after it.
  void undo(std::size_t mark) { log_.undo(mark); }
  /// Whether it writes: not while it does again what the log has.
  void record(bool records) { records_ = records; }

 private:
  void write(const ProcedureRow& row) {
    if (records_) log_.event(row);
  }

  ProcedureLog& log_;
  bool records_ = true;
};

}  // namespace stylet
