// The panel beside the tissue: numbers, sliders, plots; messages and the list of keys over it.
#pragma once

#include "stylet/view/camera.hpp"
#include "stylet/view/frame.hpp"
#include "stylet/view/live_run.hpp"

#include <functional>
#include <string>
#include <vector>

namespace stylet {

/// What the user chose to see.
struct Look {
  Colouring colouring = Colouring::none;
  bool picture = true;
  bool edges = false;
  bool contacts = true;
  bool names = true;
  bool panel = true;
  bool help = false;
  double size = 1;  ///< of letters and marks
};

/// What the drawing side measures itself.
struct DrawingPace {
  double frames_per_second = 0;
  double delay = 0;  ///< s, from the hand to the picture; 0: unknown
};

/// What was asked for in the panel.
struct Wishes {
  std::vector<std::function<void(LiveRun&)>> orders;
  bool pause = false;  ///< or go on
  bool fit = false;
};

/// Width that the panel takes of a window (pixels).
[[nodiscard]] double panel_width(const Look& look, double window_width);

/// Between NewFrame and Render.
[[nodiscard]] Wishes draw_panel(
    const Frame& frame, const DrawingPace& pace, bool paused, const Pane& pane, Look& look);

/// Notices and errors at the top of the tissue; an error offers to undo.
[[nodiscard]] Wishes draw_messages(const Frame& frame, const Pane& pane);

void draw_help(const Pane& pane, Look& look);

}  // namespace stylet
