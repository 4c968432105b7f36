// A whole run from a scene to the files of its output folder.
#pragma once

#include "stylet/scene/scene.hpp"
#include "stylet/simulation/accuracy.hpp"

#include <mpi.h>
#include <nlohmann/json.hpp>

#include <optional>
#include <string>

namespace stylet {

struct RunOptions {
  std::string output;  ///< folder; empty: the scene's, or out/<name of the scene file>
  bool force = false;  ///< write into a folder that holds an earlier run
  bool quiet = false;
  std::optional<Accuracy> accuracy;   ///< of this scene, for the uncertainty of its numbers
  std::string accuracy_missing = {};  ///< why the one that is stored does not hold
};

struct RunOutcome {
  std::string folder;
  nlohmann::ordered_json summary;
  int failed_expectations = 0;
};

/// Files that the scene names, by absolute paths.
[[nodiscard]] Scene with_absolute_paths(Scene scene);

/// YAML of a scene with every default written out and its mesh by an absolute path: it runs again from
/// any folder.
[[nodiscard]] std::string resolved_text(Scene scene);

/// Collective. Runs the scene, writes its files and prints the placement errors. After a numerical
/// failure the files hold what there is, summary.json says why, and the error is thrown on.
RunOutcome run(MPI_Comm comm, const Scene& scene, const RunOptions& options);

}  // namespace stylet
