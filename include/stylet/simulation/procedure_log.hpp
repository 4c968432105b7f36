// The file of a procedure as it happens: a scene, written at the start, and rows behind it.
#pragma once

#include "stylet/scene/procedure.hpp"
#include "stylet/scene/scene.hpp"

#include <chrono>
#include <cstddef>
#include <fstream>
#include <string>

namespace stylet {

/// Rows are in the file, as far as the operating system goes, with every event and at least every
/// second of steps.
class ProcedureLog {
 public:
  /// Writes scene.yaml and an empty procedure.yaml into an existing folder. scene: of the simulation
  /// with the live hand, as it was given to it. Throws IoError.
  ProcedureLog(const Scene& scene, const std::string& folder);
  ProcedureLog(const ProcedureLog&) = delete;
  ProcedureLog& operator=(const ProcedureLog&) = delete;
  ~ProcedureLog();

  /// Of the tip (m/s), in a step of h (s).
  void step(double speed, double h);
  void event(const ProcedureRow& row);
  [[nodiscard]] std::size_t mark();
  void undo(std::size_t mark);
  void flush();

 private:
  void write(const ProcedureRow& row);
  void put(const std::string& line);

  std::string path_;
  std::ofstream file_;
  ProcedureRow steps_;  ///< that are not in the file yet
  std::size_t n_rows_ = 0;
  std::chrono::steady_clock::time_point since_;
};

/// What a live hand needs of a scene: no needles, no end, nothing expected; the needles of the scene
/// may serve as models of those that enter.
[[nodiscard]] Scene for_live_hand(Scene scene);

}  // namespace stylet
