// A scene under the hand of a physician.
#pragma once

#include "stylet/view/live_run.hpp"
#include "stylet/view/player.hpp"
#include "stylet/view/window.hpp"

#include <mpi.h>

#include <string>

namespace stylet {

struct ViewOptions {
  std::string script;               ///< file; empty: a window
  std::string frames = "out/view";  ///< folder of a script's pictures
  PictureSize size;
  double letters = 1;
  double seconds = 0;  ///< the window closes itself after these; 0: never
};

/// Collective, on one rank. Until the window is closed or the script is at its end.
void view(MPI_Comm comm, LiveOptions live, const ViewOptions& options);

}  // namespace stylet
