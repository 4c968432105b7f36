// A procedure by hand: the simulation, what the hand wants of it, and how it goes back. Needs no
// screen and no clock; one thread calls it.
#pragma once

#include "stylet/simulation/change.hpp"
#include "stylet/simulation/planned.hpp"
#include "stylet/simulation/recording.hpp"
#include "stylet/simulation/score.hpp"
#include "stylet/simulation/simulation.hpp"
#include "stylet/view/approach.hpp"
#include "stylet/view/frame.hpp"
#include "stylet/view/scene_source.hpp"
#include "stylet/view/trace.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace stylet {

/// Where the hand holds the needle. Heights count while it is outside the tissue.
struct Aim {
  double height = 0;  ///< m, across
  double tip = 0;     ///< m, along; it goes there as fast as it may
};

/// The tip moves at this speed until something else is wanted.
struct Push {
  double height = 0;
  double speed = 0;  ///< m/s; positive pushes, negative pulls
};

struct LiveOptions {
  SceneSource source;  ///< one with a recorded procedure is done again, until the hand takes over
  /// Of the placement error at rest, by target (m), where a study knows them.
  std::map<std::string, double> bands = {};
  std::string record = {};               ///< recordings go to record-1, record-2, ...; empty: none
  std::optional<SceneSource> plan = {};  ///< what is to be done, for the overlay
};

class LiveRun {
 public:
  /// Collective. Throws InputError where the scene cannot be run by hand.
  LiveRun(MPI_Comm comm, LiveOptions options);

  /// Ends a replay.
  void want(const std::variant<Aim, Push>& wanted);
  [[nodiscard]] double speed_limit() const { return hand_->speed_limit().value(); }  ///< m/s
  /// Leaves a seed before the next step; not where the tip has not cut its way in. target: of the seed;
  /// empty: the nearest that has none.
  void seed(const std::string& target = {});
  /// Collective. The method of time stepping, as time.method; all begins anew.
  void choose_method(const std::string& method);
  /// Collective. A number that `parameters` lists, in SI, at once; of a needle also for those to come.
  void change(const std::string& key, double value);
  /// What may change now.
  [[nodiscard]] std::vector<Changeable> parameters() const;
  /// Collective. Back to before the last seed was left or the last needle entered; also after an error.
  /// False if there was none.
  bool undo();
  /// Collective.
  void restart();

  /// Collective. A step of the scene. Throws NumericalError; then only undo and restart go on.
  void step();

  [[nodiscard]] const Simulation& simulation() const { return *simulation_; }
  /// As it was given.
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] double step_length() const { return scene_.time.step; }
  [[nodiscard]] std::string method() const;
  /// Something of the needle is in the tissue.
  [[nodiscard]] bool in_tissue() const;
  [[nodiscard]] double height() const { return height_; }  ///< of the needle, in or out (m)
  [[nodiscard]] double tip() const;                        ///< of it, along (m)
  [[nodiscard]] double skin() const { return approach_.skin; }
  [[nodiscard]] double deepest() const { return approach_.deepest; }
  [[nodiscard]] const StepRecord& last_step() const { return last_; }
  [[nodiscard]] const std::string& notice() const { return notice_; }
  [[nodiscard]] bool can_undo() const;
  /// Counts undos and restarts: the needle is not where it was.
  [[nodiscard]] int epoch() const { return epoch_; }
  [[nodiscard]] const Trace& trace() const { return trace_; }
  [[nodiscard]] bool replays() const { return !rows_.empty(); }
  [[nodiscard]] const std::vector<PlannedWay>& planned() const { return planned_; }
  /// Folder of the recording; empty: none.
  [[nodiscard]] const std::string& folder() const { return folder_; }
  /// Collective. How it went; also into the folder of the recording.
  [[nodiscard]] Score finish();
  /// Of the placement error at rest in the scene's own procedure, half width (m); none: unknown.
  [[nodiscard]] std::optional<double> band(const std::string& target) const;

 private:
  /// What was done before a step, for a replay. A number is the speed from then on (m/s).
  struct SeedFor {
    std::string target;
  };
  struct Change {
    std::string key;
    double value = 0;
  };
  using Act = std::variant<NeedleParameters, SeedFor, Change, double>;
  struct Done {
    long step = 0;
    Act act;
    std::size_t mark = 0;  ///< of the recording before it
  };
  static bool is_mark(const Done& done);

  void load();
  void take_models();
  void begin(bool records);
  void guide();
  void follow();
  void choose_height(double height);
  void enter();
  void record(Act act);
  void obey(const Act& act);
  void advance();
  void tell(std::string notice);
  [[nodiscard]] NeedleParameters next_needle() const;
  [[nodiscard]] std::string nearest_target() const;

  MPI_Comm comm_;
  LiveOptions options_;
  std::vector<std::string> method_overrides_;
  std::string folder_;
  Scene scene_;
  std::vector<ProcedureRow> script_;      ///< of the scene
  std::vector<ProcedureRow> rows_;        ///< of it, still to be done
  double elapsed_ = 0;                    ///< in the first of them (s)
  std::vector<NeedleParameters> models_;  ///< of needles that enter
  std::vector<PlannedWay> planned_;
  std::unique_ptr<ProcedureLog> log_;
  std::unique_ptr<Simulation> simulation_;
  LiveHand* hand_ = nullptr;
  RecordingHand* recording_ = nullptr;  ///< the same, where it records
  std::variant<Aim, Push> wanted_;
  double height_ = 0;
  double outside_ = 0;        ///< place of the tip of a needle that has not entered (m, along)
  bool has_entered_ = false;  ///< the needle that is held
  Approach approach_;
  double speed_ = 0;
  int n_entered_ = 0;
  bool changed_ = false;  ///< some number, since the start
  long n_steps_ = 0;
  std::vector<Done> done_;
  StepRecord last_;
  Trace trace_;
  std::string notice_;
  long notice_at_ = 0;  ///< step
  int epoch_ = 0;
};

}  // namespace stylet
