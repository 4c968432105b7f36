// Plays a script off the screen.
#pragma once

#include "stylet/view/display.hpp"
#include "stylet/view/live_run.hpp"
#include "stylet/view/script.hpp"

#include <map>
#include <string>
#include <vector>

namespace stylet {

struct PictureSize {
  int width = 1280;  ///< pixels
  int height = 800;
};

class Player {
 public:
  /// run, display: lent; of the same scene. folder: where pictures go; it exists.
  Player(LiveRun& run, Display& display, std::string folder, PictureSize size);

  /// Collective. Throws what a line's argument or the physics throws; a numerical error only if no later
  /// line undoes it.
  void play(const std::vector<ScriptLine>& lines);

 private:
  void obey(const ScriptLine& line);
  void change(const std::string& text);
  void go_to(double time);
  void draw();
  void screenshot(const std::string& name);

  LiveRun& run_;
  Display& display_;
  std::string folder_;
  PictureSize size_;
  Push push_;
  double time_ = 0;  ///< of the script (s)
  double film_rate_ = 0;
  double next_frame_ = 0;  ///< s
  int n_frames_ = 0;
  Frame frame_;
  std::string error_;
};

}  // namespace stylet
