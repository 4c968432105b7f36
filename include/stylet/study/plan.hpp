// Where to send the needle so that its seeds end up at their targets.
#pragma once

#include "stylet/scene/scene.hpp"
#include "stylet/simulation/accuracy.hpp"
#include "stylet/study/study_folder.hpp"

#include <mpi.h>
#include <nlohmann/json.hpp>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

struct PlanOptions {
  StudyOptions study;
  double depth_range = 15e-3;  ///< m to either side of the scene's stops
  double height_range = 5e-3;  ///< m to either side of the scene's heights; 0: kept
  std::optional<std::array<double, 2>> speeds;  ///< m/s, of all inserts; none: the scene's
  double tolerance = 0.05e-3;                   ///< m; of the placement error, root mean square
  std::optional<Accuracy> accuracy;  ///< of the scene, for the numerical uncertainty of the plan
  int most_runs = 60;                ///< a needle
};

/// One seed before and after.
struct PlannedSeed {
  std::string needle;
  std::string target;
  double error_before = 0;  ///< m, with the scene as it is
  double error = 0;         ///< m, as planned
  double jitter = 0;        ///< m; standard deviation of the place over small shifts of the plan
  std::optional<Uncertainty> uncertainty;  ///< m; numerical, of the place
};

struct Plan {
  std::string folder;
  Scene scene;  ///< as planned
  std::vector<PlannedSeed> seeds;
  /// Where the seeds are not at their targets: variables at an end of their range, needles that have used
  /// up their runs.
  std::vector<std::string> shortfalls;
  int runs = 0;
};

/// Collective. Needle by needle, in the tissue that the earlier ones leave: heights of needles and
/// stops before implants, by TAO's POUNDERS on the vectors from targets to seeds (S. M. Wild, in
/// Advances and Trends in Optimization, 2017), which needs no derivatives and does not follow noise
/// below the tolerance. Writes planned.yaml and what all
/// studies write; a plan that is resumed takes the same way through the runs that it has. Throws InputError for a scene
/// without targets, NumericalError where a run fails, and, with everything written, where the plan
/// ends at an end of its range, or with its runs, without reaching the tolerance.
Plan plan(MPI_Comm comm, const Scene& scene, const PlanOptions& options);

/// NumericalError of a plan that falls short.
[[noreturn]] void throw_shortfalls(const Plan& plan);

/// What summary.json says of it.
[[nodiscard]] nlohmann::ordered_json summary_of(const Plan& plan);

/// Tables on standard output. given: the scene before planning.
void print(const Plan& plan, const Scene& given);

}  // namespace stylet
