// What a run leaves on disk: history.csv, snapshots.h5, summary.json.
#pragma once

#include "stylet/output/history.hpp"
#include "stylet/output/snapshots.hpp"
#include "stylet/simulation/simulation.hpp"

#include <nlohmann/json.hpp>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

/// How far the files of a run are.
struct RecorderPlace {
  HistoryPlace history;
  std::optional<SnapshotPlace> snapshots;
  void archive(Archive& archive);
};

class Recorder {
 public:
  /// Collective. Opens what the scene's output block asks for, in an existing folder, and writes the
  /// first snapshot; or goes on from where the files were, where they have been.
  Recorder(MPI_Comm comm,
           const Simulation& simulation,
           const std::string& folder,
           const RecorderPlace& from = {});

  /// Collective. A row of the history, and a snapshot when its time has come.
  void record(const Simulation& simulation, const StepRecord& step);
  /// Not collective. Whether this rank knows that the history cannot be written; `close` throws.
  [[nodiscard]] bool failed() const { return history_ && history_->failed(); }
  /// Collective. Waits for the disk. Of rank 0.
  [[nodiscard]] RecorderPlace settle();
  /// Collective. The last snapshot; closes the files.
  void finish(const Simulation& simulation);
  /// Collective. Without a last snapshot.
  void close();

 private:
  void snapshot(const Simulation& simulation);
  void wait_for_next(double time, const Scene& scene);

  MPI_Comm comm_;
  std::optional<HistoryWriter> history_;
  std::optional<SnapshotWriter> snapshots_;
  double next_snapshot_ = 0;
  double last_snapshot_ = -1;
  // Snapshots are in the order of the mesh's source, so that runs on any number of ranks compare.
  std::vector<int> old_of_new_node_;
  std::vector<int> new_of_old_cell_;
};

/// Collective. The summary of a run so far. status: running, completed or failed.
[[nodiscard]] nlohmann::ordered_json summarise(MPI_Comm comm,
                                               const Simulation& simulation,
                                               const std::string& status,
                                               const std::map<std::string, double>& wall_times);

}  // namespace stylet
