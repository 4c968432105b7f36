// What lies over the tissue: needle, contacts, membrane, seeds, targets, scale. Shapes tell them apart
// besides colours.
#pragma once

#include "stylet/view/camera.hpp"
#include "stylet/view/frame.hpp"

namespace stylet {

struct OverlayLook {
  bool contacts = true;
  bool names = true;
  double size = 1;     ///< of marks and letters
  double largest = 1;  ///< of the colours' scale, in SI
};

/// Into the list behind all windows of Dear ImGui, between NewFrame and Render.
void draw_overlay(const Frame& frame, const OverlayLook& look, const Camera& camera);

/// '6.2 ± 0.3 mm', '6.2 mm (band unknown)', 'unknown'.
[[nodiscard]] std::string error_text(const std::optional<double>& error,
                                     const std::optional<double>& band);

}  // namespace stylet
