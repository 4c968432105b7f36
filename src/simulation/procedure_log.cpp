#include "stylet/simulation/procedure_log.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/simulation/run.hpp"

#include <utility>

namespace stylet {

ProcedureLog::ProcedureLog(const Scene& scene, const std::string& folder)
    : path_(folder + "/procedure.yaml"), file_(path_, std::ios::binary | std::ios::trunc) {
  std::ofstream(folder + "/scene.yaml") << resolved_text(scene);
  since_ = std::chrono::steady_clock::now();
}

void ProcedureLog::step(double speed, double h) {
  if (steps_.steps > 0 && steps_.speed != speed) flush();
  steps_.speed = speed;
  steps_.duration += h;
  ++steps_.steps;
  if (std::chrono::steady_clock::now() - since_ > std::chrono::seconds(1)) flush();
}

void ProcedureLog::event(ProcedureRow row) {
  flush();
  write(row);
}

std::size_t ProcedureLog::mark() {
  flush();
  return n_rows_;
}

void ProcedureLog::undo(std::size_t mark) {
  flush();
  ProcedureRow row{ProcedureRow::Kind::undo};
  row.rows = static_cast<int>(mark);
  write(row);
  n_rows_ = mark;
}

void ProcedureLog::flush() {
  if (steps_.steps > 0) write(std::exchange(steps_, {}));
  since_ = std::chrono::steady_clock::now();
}

void ProcedureLog::write(const ProcedureRow& row) {
  file_ << to_line(row) << std::flush;
  if (!file_) throw IoError(path_ + ": cannot be written");
  ++n_rows_;
}

Scene for_live_hand(Scene scene) {
  scene.needles.clear();
  scene.expect.clear();
  scene.time.until_implanted = false;
  scene.time.duration = 0;
  return scene;
}

}  // namespace stylet
