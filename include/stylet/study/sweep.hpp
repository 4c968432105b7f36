// A sensitivity campaign: many runs of one scene with some of its keys changed.
#pragma once

#include "stylet/study/campaign.hpp"
#include "stylet/study/study_folder.hpp"

#include <mpi.h>

namespace stylet {

struct SweepOutcome {
  std::string folder;
  int runs = 0;  ///< of the campaign
  int kept = 0;  ///< done by an earlier start
  int failed = 0;
  double seconds = 0;
};

/// Collective. Writes plan.json, results.csv (a row for each point and shift) and scenes/, then
/// draws. A run that fails is recorded with its reason. Throws InputError if the first run is not
/// valid, NumericalError if all runs failed.
SweepOutcome sweep(MPI_Comm comm, const Campaign& campaign, const StudyOptions& options);

}  // namespace stylet
