// What all studies of many runs share on disk: plan.json says what is run, results.csv grows by a row a
// run, scenes/ has the resolved scenes; a killed study goes on with --resume, also inside a run
// (study_run.hpp).
#pragma once

#include "stylet/output/folder.hpp"
#include "stylet/scene/scene.hpp"
#include "stylet/study/table.hpp"

#include <mpi.h>
#include <nlohmann/json_fwd.hpp>

#include <memory>
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

/// A study's folder while it runs.
struct OpenStudy {
  std::unique_ptr<OutputFolder> folder;
  Table kept;  ///< rows of an earlier start
};

/// Collective. Makes the folder with plan.json and scenes/, or finds the one to be resumed. Throws
/// InputError if the folder cannot be used (OutputFolder), or was made by another plan: then it says
/// what differs. `names`: what the verb writes beside what all studies do.
[[nodiscard]] OpenStudy open_study(MPI_Comm comm,
                                   const std::string& path,
                                   const std::string& verb,
                                   std::vector<std::string> names,
                                   const StudyOptions& options,
                                   const nlohmann::ordered_json& plan,
                                   std::vector<std::string> columns);

/// Collective. The rows of a study by the same plan in another folder. Throws InputError if the plan
/// was another one, or the study is going on.
[[nodiscard]] Table read_study(MPI_Comm comm,
                               const std::string& path,
                               const nlohmann::ordered_json& plan,
                               std::vector<std::string> columns);

/// Collective over the ranks of one run. scenes/<id>.yaml.
void keep_scene(MPI_Comm comm,
                const std::string& folder,
                const std::string& id,
                const Scene& scene);

/// Of a script of jobs/, as seen from the program: where it was installed, or in the build beside it.
[[nodiscard]] std::string script_path(const std::string& script);

/// Collective. Runs jobs/<script> FOLDER on rank 0, which draws the picture and prints the report. Says
/// how to do it by hand where that fails.
void draw(MPI_Comm comm, const std::string& script, const std::string& folder, bool quiet);

}  // namespace stylet
