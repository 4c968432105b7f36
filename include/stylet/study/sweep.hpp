// A sensitivity campaign: many runs of one scene with some of its keys changed.
#pragma once

#include "stylet/study/campaign.hpp"
#include "stylet/study/parts.hpp"
#include "stylet/study/study_folder.hpp"

#include <mpi.h>

#include <optional>

namespace stylet {

struct SweepOptions {
  StudyOptions study;
  std::optional<Part> part;  ///< run this part only, in a folder of its own, without a picture
  bool join = false;         ///< take the parts' results over, then run what is missing
};

struct SweepOutcome {
  std::string folder;
  int runs = 0;  ///< of the campaign, or of the part
  int kept = 0;  ///< done by an earlier start or by a part
  int failed = 0;
  double seconds = 0;
};

/// Collective. Writes plan.json, results.csv (a row for each point and shift) and scenes/, then
/// draws. A run that fails is recorded with its reason. Throws InputError if the first run is not
/// valid, NumericalError if all runs of the campaign failed.
SweepOutcome sweep(MPI_Comm comm, const Campaign& campaign, const SweepOptions& options);

}  // namespace stylet
