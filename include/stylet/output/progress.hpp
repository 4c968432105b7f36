// How far a run is, on standard error.
#pragma once

#include <mpi.h>

#include <chrono>
#include <cstdio>
#include <string>
#include <string_view>

namespace stylet {

/// One line that is overwritten on a terminal; in a log file a line now and then. Rank 0 only,
/// nothing is collective, and a call that shows nothing only reads the clock.
class Progress {
 public:
  Progress(MPI_Comm comm, bool quiet, std::FILE* out = stderr);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  /// Whether `update` would show a line now: ask before composing an expensive text.
  [[nodiscard]] bool due() const;
  /// `fraction` of the work that is done, 0 to 1.
  void update(double fraction, std::string_view text);
  /// A line that stays; shown at once.
  void note(std::string_view text);

 private:
  using Clock = std::chrono::steady_clock;

  void print(std::string_view line, bool stays);

  bool active_;
  std::FILE* out_;
  bool terminal_;
  bool line_open_ = false;  // the cursor stands in a line that will be overwritten
  Clock::time_point start_;
  Clock::time_point next_;
};

/// " 42 %  text  elapsed 0:12, left 0:17". The time left is missing as long as nothing is done.
[[nodiscard]] std::string progress_line(double fraction, double elapsed, std::string_view text);

/// Seconds as m:ss or h:mm:ss.
[[nodiscard]] std::string clock_text(double seconds);

}  // namespace stylet
