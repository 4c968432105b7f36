#include "stylet/simulation/procedure_log.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/scene/writer.hpp"
#include "stylet/simulation/run.hpp"

#include <utility>

namespace stylet {

namespace {

constexpr const char* file_name = "procedure.yaml";
constexpr auto longest_delay = std::chrono::milliseconds(900);

}  // namespace

ProcedureLog::ProcedureLog(const Scene& scene, const std::string& folder)
    : path_(folder + "/" + file_name), file_(path_, std::ios::binary | std::ios::trunc) {
  Scene recorded = with_absolute_paths(for_live_hand(scene));
  recorded.procedure = ProcedureParameters{file_name, {}};
  const std::string scene_path = folder + "/scene.yaml";
  std::ofstream scene_file(scene_path, std::ios::binary | std::ios::trunc);
  scene_file << to_yaml(recorded) << std::flush;
  if (!scene_file) throw IoError(scene_path + ": cannot be written");
  put("# A procedure as it happened; scene.yaml beside it runs it again.\n");
}

ProcedureLog::~ProcedureLog() {
  try {
    flush();
  } catch (const IoError&) {  // was told of before, or loses the last second
  }
}

void ProcedureLog::step(double speed, double h) {
  if (steps_.steps > 0 && steps_.speed != speed) flush();
  steps_.speed = speed;
  steps_.duration += h;
  ++steps_.steps;
  if (std::chrono::steady_clock::now() - since_ >= longest_delay) flush();
}

void ProcedureLog::event(const ProcedureRow& row) {
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
  put(to_line(row));
  ++n_rows_;
}

void ProcedureLog::put(const std::string& line) {
  file_ << line << std::flush;
  if (!file_) throw IoError(path_ + ": cannot be written");
  since_ = std::chrono::steady_clock::now();
}

Scene for_live_hand(Scene scene) {
  scene.needles.clear();
  scene.expect.clear();
  scene.procedure.reset();
  scene.time.until_implanted = false;
  scene.time.duration = 0;
  return scene;
}

}  // namespace stylet
