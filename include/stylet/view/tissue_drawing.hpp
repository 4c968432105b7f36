// The deformed tissue by OpenGL: the picture carried along by the mesh, colours, edges.
#pragma once

#include "stylet/image/picture.hpp"
#include "stylet/view/camera.hpp"
#include "stylet/view/frame.hpp"
#include "stylet/view/gl.hpp"

#include <cstdint>

namespace stylet {

struct TissueLook {
  bool picture = true;
  bool edges = false;
  double largest = 1;  ///< value that gets the brightest colour
};

class TissueDrawing {
 public:
  /// picture: of the undeformed tissue in the scene's frame. A context of OpenGL 3.3 is current here and
  /// in all calls.
  explicit TissueDrawing(const Picture& picture);

  /// pixel_ratio: pixels of the display to one of the window's; window_height: in those of the window.
  void draw(const Frame& frame,
            const TissueLook& look,
            const Camera& camera,
            double pixel_ratio,
            double window_height);

 private:
  void upload(const Frame& frame);

  GlProgram program_;
  GlArray array_;
  GlBuffer reference_;
  GlBuffer displacement_;
  GlBuffer triangles_;
  GlBuffer colours_;
  GlTexture picture_;
  GlTexture colour_buffer_;
  GlTexture map_;
  Picture place_;  ///< without its bytes
  std::uint64_t uploaded_ = 0;
};

}  // namespace stylet
