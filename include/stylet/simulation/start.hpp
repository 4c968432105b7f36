// A scene that begins in the tissue that another run has left.
#pragma once

#include "stylet/base/archive.hpp"
#include "stylet/scene/scene.hpp"

#include <mpi.h>

#include <string>

namespace stylet {

/// What is taken from a checkpoint.
struct StartState {
  Archive::Columns state;
  bool other_step = false;  ///< time.step is another one from there on
  std::string fingerprint;  ///< of the file
};

/// Collective. The state that `scene`, in the needle's coordinates, starts from. Its time goes on there, and
/// what lies before is as it was: throws InputError, which names the key, unless the scenes differ only in what needles
/// do after that time, targets, output and end; or where the file is no whole checkpoint.
[[nodiscard]] StartState state_to_start_from(MPI_Comm comm,
                                             Scene scene,
                                             const std::string& mesh_fingerprint);

/// Throws InputError where the file lies in a folder whose results are to be replaced.
void require_start_kept(const Scene& scene, const std::string& folder);

}  // namespace stylet
