// A scene as it runs: hand, needles, tissue and seeds.
#pragma once

#include "stylet/geometry/rotation.hpp"
#include "stylet/needle/needle.hpp"
#include "stylet/scene/scene.hpp"
#include "stylet/simulation/body.hpp"
#include "stylet/simulation/hand.hpp"
#include "stylet/simulation/model.hpp"
#include "stylet/simulation/seed.hpp"
#include "stylet/simulation/step.hpp"
#include "stylet/simulation/strain.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

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
  long long edge_flips = 0;
  long long pattern_rebuilds = 0;
  double worst_quality = 1;      ///< of any element of the reference mesh at any time
  double stable_step = 0;        ///< s; the smallest of the run; explicit only
  double peak_needle_force = 0;  ///< N
  double tip_excess = 0;  ///< most that a tip of the increment law bore above what it cuts at (N)
  double largest_aside = 0;  ///< of NeedleStepReport (m)
  NeedleCounts needle;
};

class Simulation {
 public:
  /// Collective. Throws InputError where the scene is not valid, or scene and mesh do not fit. A scene with
  /// a `document` has been checked by load_scene; who changes it in code calls `check`. track_energy:
  /// weighed after every step, for the history. hand: none for the schedule of the scene; its needles
  /// enter at places of the turned scene (`rotation`).
  Simulation(MPI_Comm comm, Scene scene, bool track_energy, std::unique_ptr<Hand> hand = nullptr);
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  ~Simulation() = default;

  [[nodiscard]] bool done() const { return done_; }
  /// Collective. Throws NumericalError when the step has no valid answer.
  StepRecord step();
  /// Collective. Sets a number in mid-run, between two steps (simulation/change.hpp has the keys; SI).
  /// True if the tissue's matrices were made anew. Throws InputError where the key does not change or the
  /// value is not allowed; nothing has happened then. A hand's order does the same, and is recorded.
  bool change(const std::string& key, double value);

  /// In the needle's coordinates, like everything here; `rotation` leads back to the scene's.
  [[nodiscard]] const Scene& scene() const { return scene_; }
  /// True if needles enter, now or later.
  [[nodiscard]] bool pierces() const { return live_ || !scene_.needles.empty(); }
  /// Needles come by a hand that the scene does not know, or by its recorded procedure.
  [[nodiscard]] bool is_live() const { return live_; }
  [[nodiscard]] const Hand& hand() const { return *hand_; }
  /// Of the checkpoint that the scene starts from; empty without one.
  [[nodiscard]] const std::string& start_fingerprint() const { return start_fingerprint_; }
  /// What reading the recorded procedure left out; empty: nothing.
  [[nodiscard]] const std::string& procedure_note() const { return procedure_note_; }
  [[nodiscard]] Rotation rotation() const { return Rotation(scene_.needle_angle); }
  [[nodiscard]] const Body& body() const { return body_; }
  [[nodiscard]] const NumberedMesh& numbered() const { return body_.numbered(); }
  [[nodiscard]] const Mesh& mesh() const { return body_.mesh(); }
  [[nodiscard]] const TissueOperator& tissue() const { return body_.tissue(); }
  [[nodiscard]] double time() const { return body_.time(); }
  /// Collective.
  [[nodiscard]] const State& state() const { return body_.state(); }
  /// Collective. To disturb it: the energy is not checked from then on.
  [[nodiscard]] State& state() { return body_.state(); }
  /// The present needle, or none before the first, or in a scene without.
  [[nodiscard]] const Needle* needle() const { return needle_ ? &*needle_ : nullptr; }
  /// What holds the tissue now, with the contacts of the end of the last step.
  [[nodiscard]] ConstraintSet constraints() const;
  [[nodiscard]] const std::vector<Seed>& seeds() const { return seeds_; }
  /// Why no seed can be left now; empty if one can.
  [[nodiscard]] std::string why_no_seed() const;
  /// Where a seed lies now, in the mesh as it is now.
  [[nodiscard]] const EmbeddedPoint& place_of(const Seed& seed) const {
    return body_.points(seed.place).front();
  }
  [[nodiscard]] const LargestStrain& largest_strain() const { return largest_strain_; }
  /// Most triangles at a time: of all in every step of a live or recorded hand, else at the moments of
  /// `largest_strain` and with every seed; around the tip in every sub-step.
  [[nodiscard]] const TurnedOver& turned_over() const { return turned_over_; }
  /// As of the last look at all triangles.
  [[nodiscard]] const TurnedOver& turned_over_now() const { return turned_over_now_; }
  /// Needles that a hand has let in, and how it pushed them; none without one.
  [[nodiscard]] const std::vector<NeedleParameters>& entered() const { return entered_; }
  [[nodiscard]] const std::vector<Pushing>& pushings() const { return pushings_; }
  [[nodiscard]] const RunCounts& counts() const { return counts_; }
  /// Up to date after every step if they are tracked, else as of the last check.
  [[nodiscard]] const Energies& energies() const { return body_.ledger().energies(); }
  [[nodiscard]] std::span<const EmbeddedPoint> membrane() const { return body_.points(membrane_); }
  [[nodiscard]] std::span<const EmbeddedPoint> probes() const { return body_.points(probes_); }
  /// Share of the scene's time that is done, 0 to 1, as far as it is known.
  [[nodiscard]] double fraction() const;
  /// Distance between a seed and its target. At the last implant of a run until then it is the
  /// final one (src/MODEL.md, section 9).
  [[nodiscard]] std::vector<double> placement_errors() const;

  /// Collective, between steps. Everything that the next steps hang on, in the order of the mesh's source.
  [[nodiscard]] Archive::Columns store();
  /// Collective. Goes on from there; a simulation of the same scene, on any number of ranks, that was just
  /// made, or the one that has stored it: both are then alike to the last bit. Throws InputError where it
  /// does not fit.
  void restore(Archive::Columns columns);

 private:
  void start_from_checkpoint(MPI_Comm comm);
  StepRecord step_unguarded();
  [[nodiscard]] std::string held_points() const;
  void act_without_time();
  void fulfil(const Wish& wish);
  void enter(const NeedleParameters& parameters);
  [[nodiscard]] NeedleTissue met_in_tissue();
  void make_needle(const NeedleParameters& parameters, NeedleTissue tissue);
  [[nodiscard]] std::vector<double> region_modulus() const;
  void tell_needle();
  void implant(const std::string& target);
  void count(const SubStep& step);
  void count_forces(const NeedleForces& forces, bool punctured);
  void count_push(double way, double duration);
  void watch_tip();
  void watch_all(std::span<const double> u);
  void watch_strain();
  void archive(Archive& archive);

  std::string procedure_note_;
  std::string start_fingerprint_;
  Scene scene_;
  bool live_;
  Body body_;
  std::unique_ptr<Hand> hand_;
  bool track_energy_;
  std::optional<Needle> needle_;
  Riders membrane_;
  Riders probes_;
  std::vector<Seed> seeds_;
  RunCounts counts_;
  NeedleCounts earlier_needles_;
  double largest_tip_force_ = 0;  ///< of the present needle, at the end of a step (N)
  double last_friction_ = 0;      ///< of it (N)
  double expected_time_ = 0;      ///< s
  double next_strain_ = 0;        ///< time of the next look at all strains (s)
  LargestStrain largest_strain_;
  TurnedOver turned_over_;
  TurnedOver turned_over_now_;
  TurnedOver since_entered_;  ///< of the present needle
  std::vector<NeedleParameters> entered_;
  std::vector<Pushing> pushings_;
  bool started_ = false;
  bool done_ = false;
};

}  // namespace stylet
