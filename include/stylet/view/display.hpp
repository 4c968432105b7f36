// One picture of a frame: tissue, overlay, panel. The same in the window and off the screen.
#pragma once

#include "stylet/simulation/planned.hpp"
#include "stylet/view/camera.hpp"
#include "stylet/view/frame.hpp"
#include "stylet/view/panel.hpp"
#include "stylet/view/tissue_drawing.hpp"

#include <vector>

namespace stylet {

/// The context of Dear ImGui: its style and letters. One at a time.
class Interface {
 public:
  Interface();
  Interface(const Interface&) = delete;
  Interface& operator=(const Interface&) = delete;
  ~Interface();
};

class Display {
 public:
  /// A context of OpenGL 3.3 and an Interface are there, here and in all calls.
  explicit Display(const Picture& picture);
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  ~Display();

  Look look;
  Camera camera;
  std::vector<PlannedWay> planned;  ///< drawn over the tissue

  /// Of the whole window (pixels); the tissue gets what the panel leaves. Before the mouse is asked.
  void resize(double width, double height);
  /// Shows the whole tissue, and room in front of it for a needle.
  void fit(const Frame& frame);
  /// Into the framebuffer that is bound. Dear ImGui knows the sizes, and its platform part has begun the
  /// frame.
  Wishes draw(const Frame& frame, const DrawingPace& pace, bool paused);

 private:
  TissueDrawing tissue_;
  double width_ = 1;
  double height_ = 1;
  double largest_ = 0;  ///< of the colours, so far
  Colouring scaled_ = Colouring::none;
};

}  // namespace stylet
