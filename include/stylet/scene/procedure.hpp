// A recorded procedure: what a hand did, row by row.
//
// The file is a YAML list with one row a line, so that a program that is killed leaves at most a torn
// last line:
//
//   - {enter: {name: needle1, height: 0.032 m, cutting: {...}, friction: {...}}}
//   - {move: {speed: 0.02 m/s, duration: 1.5 s, steps: 300}}
//   - {implant: {target: seed}}
//   - {change: {key: tissue.regions.prostate.youngs_modulus, value: 90000}}
//   - {undo: {rows: 2}}
#pragma once

#include "stylet/needle/parameters.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace stylet {

struct ProcedureRow {
  enum class Kind { enter, move, implant, change, undo };
  Kind kind = Kind::move;
  NeedleParameters needle = {};  ///< enter; without motion
  double speed = 0;              ///< move: of the tip, positive pushes (m/s)
  double duration = 0;           ///< move: sum of the steps (s)
  int steps = 0;                 ///< move: as many solved
  std::string target = {};       ///< implant
  std::string key = {};          ///< change
  double value = 0;              ///< change: in SI
  int rows = 0;                  ///< undo: that remain of all before
};

/// Checked rows, undone ones left out. A last line without an end is left out too, and `note` says so.
/// Throws InputError with file and line.
[[nodiscard]] std::vector<ProcedureRow> read_procedure(const std::string& file_name,
                                                       const std::string& text,
                                                       std::string& note);

/// One line, with its end.
[[nodiscard]] std::string to_line(const ProcedureRow& row);

}  // namespace stylet
