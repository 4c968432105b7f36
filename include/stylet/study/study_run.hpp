// One run of a study: a scene without files of its own, whose failure is a result.
#pragma once

#include "stylet/simulation/simulation.hpp"
#include "stylet/study/identity.hpp"
#include "stylet/study/pool.hpp"

#include <nlohmann/json.hpp>

#include <functional>
#include <string>

namespace stylet {

struct StudyRun {
  std::string error;               ///< empty: it came to its end
  double seconds = 0;              ///< wall time, set-up included
  nlohmann::ordered_json summary;  ///< as summary.json; empty after an error
};

using Inspect = std::function<void(const Simulation&)>;

/// Collective. A scene that does not fit its mesh and a step without a valid answer become `error`;
/// everything else throws, a mesh file that is no longer the study's too: no result of a scene.
/// inspect: collective, after every step.
[[nodiscard]] StudyRun run_in_study(MPI_Comm comm,
                                    const Scene& scene,
                                    const MeshFiles& meshes,
                                    const Poll& poll,
                                    const Inspect& inspect = {});

/// Shown and stored as one line.
[[nodiscard]] std::string one_line(std::string text);

}  // namespace stylet
