// One needle: a state machine that plans edits, conditions and forces, and judges their outcome.
//
// A step goes: start_step; then, as long as wants_edit, plan (the caller applies the edits); then
// conditions (the caller solves); then review, which accepts or asks for another round from the
// saved state; then commit. No Mat, Vec or KSP here.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/advance_search.hpp"
#include "stylet/needle/contact_work.hpp"
#include "stylet/needle/cutting.hpp"
#include "stylet/needle/motion.hpp"
#include "stylet/needle/parameters.hpp"
#include "stylet/needle/reference_path.hpp"
#include "stylet/needle/shaft_contacts.hpp"
#include "stylet/needle/track_view.hpp"
#include "stylet/needle/view.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

enum class NeedlePhase { outside, inserting, holding, retracting, withdrawn };
[[nodiscard]] const char* name_of(NeedlePhase phase);

/// stick: the tip pushes the tissue that it stands in, by a condition; cut: it cuts, at the threshold
/// force; open: it does not touch the end of its path.
enum class TipContact { stick, cut, open };

/// Forces of the needle on the tissue, along the axis (N), positive in the direction of insertion.
struct NeedleForces {
  double tip = 0;
  double friction = 0;
  [[nodiscard]] double total() const { return tip + friction; }
};

/// What an accepted step did.
struct NeedleStepReport {
  NeedleForces forces;
  double work = 0;        ///< J, done by the hand
  double dissipated = 0;  ///< J of it, by cutting and friction; the rest went into the tissue
  int n_stick = 0;
  int n_slip = 0;
  int contact_changes = 0;
  double aside =
      0;  ///< in space: how far tissue that the needle now takes hold of was off its axis (m)
};

/// How the tip stands where a seed is left.
struct TipStand {
  double lag = 0;      ///< m of advance that the cutting law has left to later steps
  double force = 0;    ///< N, on the tip
  double needed = 0;   ///< N, at which all of the tip cuts on
  double element = 0;  ///< m, size of the elements around it
  bool at_membrane = false;
  /// How far the needle has been behind the place where it last broke a membrane, as a share of its way
  /// behind the skin; 1 if it never did.
  double since_puncture = 1;
};

void archive(Archive& archive, TipStand& stand);

class Needle {
 public:
  /// velocity_level: contact is decided by velocities (central difference). The tip stands at the begin of
  /// the path, at the place 0 along it.
  Needle(NeedleParameters parameters, std::unique_ptr<ReferencePath> path, bool velocity_level);
  /// In triangles; the mesh is lent.
  Needle(const Mesh& mesh, NeedleParameters parameters, NeedleTissue tissue, bool velocity_level);

  /// In triangles. The skin node slides to the axis; start: the two nodes of the entry. Returns the edit.
  /// The tip stands at the skin afterwards.
  NeedleEdits enter(const Entry& entry, const NeedleView& start);
  /// What later needles find: the earlier cuts and this needle's.
  [[nodiscard]] EarlierCuts leave() const { return path_->leave(); }

  /// Between two steps: other forces at which the tip cuts and the shaft slides, of the same laws, and
  /// other numbers of the tissue (as in NeedleTissue).
  void change(const CuttingParameters& cutting,
              const std::optional<FrictionParameters>& friction,
              double puncture_force,
              std::vector<double> region_modulus);

  /// Nodes whose start-of-step state `plan` needs; ascending.
  [[nodiscard]] std::vector<int> watched() const { return path_->watched(); }
  /// Points whose trial the review needs; ascending.
  [[nodiscard]] std::vector<int> loaded_points() const;
  /// What stands behind points.
  [[nodiscard]] const TrackOperator& track_operator() const { return *path_; }

  /// A needle that is out of the tissue takes no part in a step, unless it goes in again.
  [[nodiscard]] bool takes_part(const NeedleStep& step) const {
    return !released() || step.speed() > 0;
  }
  /// Takes no part.
  void move_free(const NeedleStep& step) { tip_along_ = step.to; }
  void start_step(const NeedleStep& step);
  /// The same step from the same start, which ends sooner: its edits and contacts stay.
  void shorten_step(const NeedleStep& step);
  [[nodiscard]] bool wants_edit() const { return path_->wants_edit(); }
  /// Throws NumericalError if the tip cannot go on.
  NeedleEdits plan(const NeedleView& start);
  [[nodiscard]] TrackConditions conditions() const;
  /// True: the step is accepted. Throws NumericalError where the advance has no solution.
  bool review(const TrackTrial& trial, const Multiplier& lambda);
  /// start: the loaded points after the last edits; end_weight: of the forces at the end of the step in
  /// its work, those at its start have the rest.
  NeedleStepReport commit(const TrackStart& start,
                          const TrackTrial& trial,
                          Multiplier lambda,
                          double end_weight = 1);

  [[nodiscard]] const NeedleParameters& parameters() const { return parameters_; }
  /// The point of the axis at a place along it.
  [[nodiscard]] WorldPlace on_axis(double along) const { return path_->on_axis(along); }
  /// Places along the axis (m): of the needle's own tip, and of the skin when it entered.
  [[nodiscard]] double tip() const { return tip_along_; }
  [[nodiscard]] double skin() const { return skin_along_; }
  [[nodiscard]] const Track& track() const { return path_->track(); }
  [[nodiscard]] const ReferencePath& path() const { return *path_; }
  [[nodiscard]] double path_length() const { return path_->length(); }
  [[nodiscard]] NeedlePhase phase() const { return phase_; }
  [[nodiscard]] TipContact tip_contact() const { return tip_; }
  /// Tip force (N) at which a tip that is in with all of its length cuts on, or punctures the membrane.
  [[nodiscard]] double force_to_cut() const;
  [[nodiscard]] TipStand stand() const;
  [[nodiscard]] bool at_membrane() const { return path_->at_membrane(); }
  [[nodiscard]] const NeedleCounts& counts() const { return path_->counts(); }
  /// Where the tip stands in the reference mesh: the end of the path, or the point of the path that
  /// a withdrawing tip has come back to.
  [[nodiscard]] ReferencePlace tip_point() const { return path_->tip_point(); }
  /// True if every node of the path has been released.
  [[nodiscard]] bool released() const { return path_->is_released(); }

  /// Between steps; loaded into a needle with the same parameters.
  void archive(Archive& archive);

 private:
  [[nodiscard]] bool searches() const { return stylet::searches(parameters_.cutting); }
  /// A place to be reached in one step would be a blow: the gap is left to later cuts.
  [[nodiscard]] bool holds_by_rate() const {
    return velocity_level_ && parameters_.cutting.law == CuttingLaw::lagged;
  }
  [[nodiscard]] double full_threshold() const;
  [[nodiscard]] double threshold() const;
  [[nodiscard]] double limit() const;
  [[nodiscard]] double tolerance() const;
  [[nodiscard]] double slack() const;
  [[nodiscard]] double place_gap(const TrackTrial& trial) const;
  [[nodiscard]] double gap(const TrackTrial& trial) const;
  void forget_search();
  bool review_friction(const TrackTrial& trial);
  bool review_tip(const TrackTrial& trial, const Multiplier& lambda);
  bool cut_further(double gap);
  [[noreturn]] void throw_no_solution() const;
  void check_tip(const TrackTrial& trial, double lambda) const;
  std::vector<PointForce> tip_forces(const Multiplier& lambda) const;
  double taken_aside(const TrackStart& start);

  NeedleParameters parameters_;
  bool velocity_level_;
  std::unique_ptr<ReferencePath> path_;
  ShaftContacts contacts_;
  AdvanceSearch search_;
  ContactWork work_;
  double tip_along_ = 0;
  double skin_along_ = 0;
  NeedleStep step_;
  NeedlePhase phase_ = NeedlePhase::outside;
  TipContact tip_ = TipContact::stick;
  std::optional<double> holds_beyond_;  ///< advance at which the search let the tip hold (m)
  double pending_ = 0;                  ///< advance left for the next step (lagged, m)
  double last_tip_force_ = 0;           ///< N
  long long punctures_ = 0;             ///< until the last step
  std::size_t n_points_ = 0;            ///< of the path, then
  std::optional<double> puncture_at_;   ///< place of the needle's tip after the last one (m)
  double deepest_since_ = 0;            ///< place of the tip since then (m)
};

}  // namespace stylet
