// What all studies of many runs share on disk: plan.json says what is run, results.csv grows by a row a
// run, scenes/ has the resolved scenes; a killed study goes on with --resume.
#pragma once

#include "stylet/scene/scene.hpp"
#include "stylet/study/table.hpp"

#include <mpi.h>
#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace stylet {

struct StudyOptions {
  std::string output;   ///< folder; empty: out/<verb>-<name of the file>
  bool force = false;   ///< replace earlier results
  bool resume = false;  ///< run only what is missing
  bool quiet = false;
  int ranks_per_run = 1;
  bool picture = true;  ///< draw it at the end
};

/// `options.output`, or the usual folder.
[[nodiscard]] std::string study_folder(const StudyOptions& options,
                                       const std::string& verb,
                                       const std::string& file);

/// Collective. Whether a study has begun in the folder.
[[nodiscard]] bool holds_study(MPI_Comm comm, const std::string& folder);

/// Collective. Makes the folder with plan.json and scenes/, or finds the one to be resumed. Returns
/// the rows that are there. Throws InputError if the folder is not empty, or was made by another
/// plan.
[[nodiscard]] Table open_study(MPI_Comm comm,
                               const std::string& folder,
                               const StudyOptions& options,
                               const nlohmann::ordered_json& plan,
                               std::vector<std::string> columns);

/// Collective over the ranks of one run. scenes/<id>.yaml.
void keep_scene(MPI_Comm comm,
                const std::string& folder,
                const std::string& id,
                const Scene& scene);

/// Collective. Runs jobs/<script> FOLDER on rank 0, which draws the picture and prints the report. Says
/// how to do it by hand where that fails.
void draw(MPI_Comm comm, const std::string& script, const std::string& folder, bool quiet);

}  // namespace stylet
