// OpenGL without a screen: by EGL, into a framebuffer of our own.
#pragma once

#include "stylet/view/gl.hpp"

#include <memory>

namespace stylet {

/// The context is current while this lives.
class OffscreenContext {
 public:
  /// Throws Error where the machine has no EGL with OpenGL 3.3 that works without a display.
  OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;
  ~OffscreenContext();

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

/// A picture to draw into, bound while this lives. pixels.
class OffscreenTarget {
 public:
  OffscreenTarget(int width, int height);

 private:
  GlTexture texture_;
  GlFramebuffer framebuffer_;
};

}  // namespace stylet
