// A scene as it runs: builds what is declared, then steps.
#pragma once

#include "stylet/dynamics/time_integrator.hpp"
#include "stylet/geometry/rotation.hpp"
#include "stylet/mesh/embedded_point.hpp"
#include "stylet/needle/motion.hpp"
#include "stylet/needle/needle.hpp"
#include "stylet/scene/scene.hpp"
#include "stylet/simulation/conditions.hpp"
#include "stylet/simulation/energy.hpp"
#include "stylet/simulation/model.hpp"
#include "stylet/simulation/settling.hpp"
#include "stylet/simulation/strain.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

struct Seed {
  std::string needle;
  std::string target;    ///< empty if the scene has none
  double time = 0;       ///< of implantation (s)
  Vector2 displacement;  ///< of the tissue there when it was implanted (m)
  EmbeddedPoint place;
  TipStand tip;
};

/// A step of `time.step`, or what an action left of it.
struct StepRecord {
  double t = 0;  ///< at its end (s)
  double h = 0;
  long long sub_steps = 0;
  long long passes = 0;      ///< solves tried
  long long iterations = 0;  ///< of KSP
  NeedleStepReport needle;
};

struct RunCounts {
  long long steps = 0;
  long long sub_steps = 0;
  long long passes = 0;
  long long iterations = 0;
  int edge_flips = 0;
  int pattern_rebuilds = 0;
  int deformed_inversions = 0;   ///< most inverted deformed elements around the tip at a time
  double worst_quality = 1;      ///< of any element of the reference mesh at any time
  double stable_step = 0;        ///< s; the smallest of the run; explicit only
  double peak_needle_force = 0;  ///< N
  NeedleCounts needle;
};

class Simulation {
 public:
  /// Collective. Throws InputError where scene and mesh do not fit. track_energy: weighed after every
  /// step, for the history.
  Simulation(MPI_Comm comm, Scene scene, bool track_energy);
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  ~Simulation() = default;

  [[nodiscard]] bool done() const { return done_; }
  /// Collective. Throws NumericalError when the step has no valid answer.
  StepRecord step();

  /// In the needle's coordinates, like everything here; `rotation` leads back to the scene's.
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] Rotation rotation() const { return Rotation(scene_.needle_angle); }
  [[nodiscard]] const NumberedMesh& numbered() const { return numbered_; }
  [[nodiscard]] const Mesh& mesh() const { return numbered_.mesh; }
  [[nodiscard]] const TissueOperator& tissue() const { return *tissue_; }
  [[nodiscard]] double time() const { return state_.t; }
  /// What solves for the whole tissue, from the first step on.
  [[nodiscard]] std::string solver() const { return integrator_->solver(); }
  /// Collective.
  [[nodiscard]] const State& state() const {
    integrator_->complete();
    return state_;
  }
  /// Collective. To disturb it: the energy is not checked from then on.
  [[nodiscard]] State& state() {
    integrator_->complete();
    ledger_.stop_checks();
    return state_;
  }
  /// The present needle, or none before the first, or in a scene without.
  [[nodiscard]] const Needle* needle() const { return needle_ ? &*needle_ : nullptr; }
  /// What holds the tissue now, with the contacts of the end of the last step.
  [[nodiscard]] ConstraintSet constraints() const;
  [[nodiscard]] const std::vector<Seed>& seeds() const { return seeds_; }
  [[nodiscard]] const Conditions& conditions() const { return conditions_; }
  [[nodiscard]] const LargestStrain& largest_strain() const { return largest_strain_; }
  [[nodiscard]] const RunCounts& counts() const { return counts_; }
  /// Up to date after every step if they are tracked, else as of the last check.
  [[nodiscard]] const Energies& energies() const { return ledger_.energies(); }
  /// The most that the energy ever exceeded the work done, as a share of the largest energy.
  [[nodiscard]] double energy_excess() const { return ledger_.worst_excess(); }
  [[nodiscard]] const std::vector<EmbeddedPoint>& membrane() const { return membrane_; }
  [[nodiscard]] const std::vector<EmbeddedPoint>& probes() const { return probes_; }
  /// Collective. World positions of embedded points.
  [[nodiscard]] std::vector<WorldPoint> world(std::span<const EmbeddedPoint> points) const;
  /// Collective. Total force on the tissue (N) that a prescribed curve needed in the last step.
  [[nodiscard]] Vector2 curve_reaction(std::size_t curve) const;
  /// Share of the scene's time that is done, 0 to 1, as far as it is known.
  [[nodiscard]] double fraction() const;
  /// Distance between a seed and its target. At the last implant of a run until then it is the
  /// final one (model.md, section 9).
  [[nodiscard]] std::vector<double> placement_errors() const;

 private:
  StepRecord step_unguarded();
  void start();
  void act_without_time();
  void enter_next_needle();
  void require_cut_in() const;
  void implant();
  Motion& motion() { return needle_ ? needle_->motion() : *clock_; }
  void watch_strain();
  double sub_step(double longest, StepRecord& record);
  bool edit_for_needle();
  void apply(const NeedleEdits& edits, bool repair);
  [[nodiscard]] NeedleView start_view(std::span<const int> nodes) const;
  [[nodiscard]] TrialView trial_view(std::span<const int> nodes,
                                     const Trial& trial,
                                     double h) const;
  [[nodiscard]] ConstraintSet needle_constraints(const Needle* active) const;
  void update_load(double t);
  [[nodiscard]] double prescribed_work(const Trial& trial) const;
  void accept(const Trial& trial, double h, const NeedleStepReport& report);
  void count_deformed_inversions();
  void end_open_action(double t0);

  Scene scene_;
  NumberedMesh numbered_;
  Conditions conditions_;
  std::unique_ptr<TissueOperator> tissue_;
  EnergyLedger ledger_;
  bool track_energy_;
  std::unique_ptr<TimeIntegrator> integrator_;
  State state_;
  OwnedVec load_;
  OwnedVec last_load_;
  double load_time_ = 0;       ///< time that load_ is of (s)
  bool load_changed_ = false;  ///< since the last accepted step
  std::vector<PrescribedDof> base_;
  OwnedVec reaction_;  ///< of the last step, where curves are prescribed
  std::size_t n_entered_ = 0;
  std::optional<Needle> needle_;
  std::optional<Motion> clock_;  ///< of a scene without a needle
  std::vector<EmbeddedPoint> membrane_;
  std::vector<EmbeddedPoint> probes_;
  std::vector<Seed> seeds_;
  RunCounts counts_;
  NeedleCounts earlier_needles_;
  double largest_tip_force_ = 0;  ///< of the present needle, at the end of a step (N)
  double estimated_time_ = 0;
  double next_strain_ = 0;  ///< time of the next look at all strains (s)
  LargestStrain largest_strain_;
  Settling settling_;
  double extent_ = 0;  ///< of the tissue along the needle (m)
  bool started_ = false;
  bool done_ = false;
};

}  // namespace stylet
