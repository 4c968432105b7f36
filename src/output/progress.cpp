#include "stylet/output/progress.hpp"

#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sys/ioctl.h>
#include <unistd.h>

namespace stylet {

namespace {

constexpr auto terminal_interval = std::chrono::milliseconds(200);
constexpr auto log_interval = std::chrono::seconds(10);
constexpr std::size_t usual_width = 80;
constexpr double longest_shown = 359999;  // 99:59:59

std::size_t terminal_width(std::FILE* out) {
  winsize size{};
  const bool known = ::ioctl(::fileno(out), TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : usual_width;
}

}  // namespace

std::string clock_text(double seconds) {
  const auto s = static_cast<int>(std::clamp(std::round(seconds), 0.0, longest_shown));
  std::array<char, 32> text;
  if (s >= 3600) {
    std::snprintf(text.data(), text.size(), "%d:%02d:%02d", s / 3600, s / 60 % 60, s % 60);
  } else {
    std::snprintf(text.data(), text.size(), "%d:%02d", s / 60, s % 60);
  }
  return text.data();
}

std::string progress_line(double fraction, double elapsed, std::string_view text) {
  const double done = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  std::array<char, 16> percent;
  std::snprintf(percent.data(), percent.size(), "%3d %%", static_cast<int>(100 * done));
  std::string line = percent.data();
  if (!text.empty()) line.append("  ").append(text);
  line += "  elapsed " + clock_text(elapsed);
  if (done > 0) line += ", left " + clock_text(elapsed * (1 - done) / done);
  return line;
}

Progress::Progress(MPI_Comm comm, bool quiet, std::FILE* out)
    : active_(!quiet && rank_of(comm) == 0),
      out_(out),
      terminal_(active_ && ::isatty(::fileno(out)) == 1),
      start_(Clock::now()),
      next_(terminal_ ? start_ : start_ + log_interval) {}

Progress::~Progress() {
  if (line_open_) std::fputc('\n', out_);  // an error message must not start in our line
}

bool Progress::due() const {
  return active_ && Clock::now() >= next_;
}

void Progress::update(double fraction, std::string_view text) {
  if (!active_) return;
  const auto now = Clock::now();
  if (now < next_) return;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  print(progress_line(fraction, elapsed, text), false);
  next_ = now + (terminal_ ? Clock::duration(terminal_interval) : Clock::duration(log_interval));
}

void Progress::note(std::string_view text) {
  if (active_) print(text, true);
}

void Progress::print(std::string_view line, bool stays) {
  if (terminal_) {
    // A line that wraps could not be overwritten.
    if (!stays) line = line.substr(0, terminal_width(out_) - 1);
    std::fprintf(out_, "\r%.*s\033[K", static_cast<int>(line.size()), line.data());
    if (stays) std::fputc('\n', out_);
    line_open_ = !stays;
  } else {
    std::fprintf(out_, "%.*s\n", static_cast<int>(line.size()), line.data());
  }
  std::fflush(out_);
}

}  // namespace stylet
