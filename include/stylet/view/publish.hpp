// Copies what is to be seen out of a procedure.
#pragma once

#include "stylet/view/frame.hpp"
#include "stylet/view/live_run.hpp"

namespace stylet {

/// What may change now, with the ends of its slider.
[[nodiscard]] std::vector<ShownParameter> parameters_of(const LiveRun& run);

/// Collective. The score, and where the recording is.
[[nodiscard]] std::string last_words(LiveRun& run);

/// Collective. All of a frame but its number, its pace and what the caller knows of the hand.
void publish(const LiveRun& run, Colouring colouring, Frame& frame);

}  // namespace stylet
