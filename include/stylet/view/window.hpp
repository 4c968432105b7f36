// The window itself: events of mouse and keyboard become orders, frames become pictures. By GLFW, in the
// thread that runs main.
#pragma once

#include "stylet/view/live_session.hpp"

#include <optional>
#include <string>

namespace stylet {

struct WindowOptions {
  std::string title = "Stylet";
  int width = 1280;  ///< pixels
  int height = 800;
  double letters = 1;                  ///< their size
  std::optional<double> seconds = {};  ///< closes itself after these; for measurements
};

/// What a window has seen, for measurements.
struct WindowReport {
  long frames = 0;
  double seconds = 0;
  double delay = 0;  ///< s, mean, from the hand to the picture
  double real_time_factor = 0;
  double busy = 0;     ///< share of the time that steps took
  double longest = 0;  ///< s, of a step
};

/// Until it is closed. Throws Error where no window can be opened.
WindowReport show_window(LiveSession& session, const WindowOptions& options);

}  // namespace stylet
