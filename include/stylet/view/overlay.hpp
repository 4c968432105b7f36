// What lies over the tissue: needle, contacts, membrane, seeds, targets, scale. Shapes tell them apart
// besides colours.
#pragma once

#include "stylet/simulation/planned.hpp"
#include "stylet/view/camera.hpp"
#include "stylet/view/frame.hpp"

#include <span>

namespace stylet {

struct OverlayLook {
  bool contacts = true;
  bool names = true;
  double size = 1;     ///< of marks and letters
  double largest = 1;  ///< of the colours' scale, in SI
  std::span<const PlannedWay> planned = {};
};

/// Into the list behind all windows of Dear ImGui, between NewFrame and Render.
void draw_overlay(const Frame& frame, const OverlayLook& look, const Camera& camera);

}  // namespace stylet
