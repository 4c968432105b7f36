// One needle: a state machine that plans edits, constraints and forces, and judges their outcome.
//
// A step goes: start_step; then, as long as wants_edit, plan (the caller applies the edits); then
// constraints (the caller solves); then review, which accepts or asks for another round from the
// saved state; then commit. No Mat, Vec or KSP here.
#pragma once

#include "stylet/dynamics/constraint_set.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/advance.hpp"
#include "stylet/needle/advance_search.hpp"
#include "stylet/needle/axis.hpp"
#include "stylet/needle/earlier_cuts.hpp"
#include "stylet/needle/motion.hpp"
#include "stylet/needle/parameters.hpp"
#include "stylet/needle/skin.hpp"
#include "stylet/needle/track.hpp"
#include "stylet/needle/view.hpp"

#include <algorithm>
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
};

/// How the tip stands where a seed is left.
struct TipStand {
  double lag = 0;      ///< m of advance that the cutting law has left to later steps
  double force = 0;    ///< N, on the tip
  double needed = 0;   ///< N, at which all of the tip cuts on
  double element = 0;  ///< m, size of the elements around it
};

struct NeedleCounts {
  int hand_overs = 0;
  int fallbacks = 0;  ///< advances along d because F was no help
  int punctures = 0;
};
[[nodiscard]] inline NeedleCounts operator+(const NeedleCounts& a, const NeedleCounts& b) {
  return {a.hand_overs + b.hand_overs, a.fallbacks + b.fallbacks, a.punctures + b.punctures};
}

/// Properties that the needle meets in the tissue.
struct NeedleTissue {
  std::vector<ReferencePoint> membrane;  ///< polygon; empty if there is none
  double puncture_force = 0;             ///< N
  std::vector<double> region_modulus;    ///< Young's modulus by region (Pa), for stiffness_share
  EarlierCuts earlier;                   ///< of the needles before
};

/// Of the needle on a node (N): what does work in a step, and what is left at its end, as in Trial.
struct NodeForce {
  int node;
  double along = 0;
  double across = 0;
  double settled_along = 0;
  double settled_across = 0;
};

/// Of the tip's condition (N), as in Trial.
struct Multiplier {
  // NOLINTNEXTLINE(google-explicit-constructor): one number where all are the same
  Multiplier(double all) : needed(all), working(all), settled(all) {}
  Multiplier(double with_blow, double that_works, double after_blow)
      : needed(with_blow), working(that_works), settled(after_blow) {}
  /// By which cutting is decided: before a blow or after it the smaller one, so that a cut that follows
  /// lets the tissue fall back. Backward Euler has one force over the whole step.
  [[nodiscard]] double bearing() const {
    const bool one_force = needed == working;
    return std::min(one_force ? needed : 2 * working - settled, settled);
  }
  double needed;
  double working;
  double settled;
};

class Needle {
 public:
  /// velocity_level: contact is decided by velocities (central difference).
  Needle(NeedleParameters parameters, NeedleTissue tissue, bool velocity_level);

  /// The skin node slides to the axis; start: the two nodes of the entry. Returns the edit. The tip
  /// stands at the skin afterwards.
  NeedleEdits enter(const Mesh& mesh, const Entry& entry, const NeedleView& start);
  /// What later needles find: the earlier cuts and this needle's.
  [[nodiscard]] EarlierCuts leave(const Mesh& mesh) const;

  /// Nodes whose start-of-step state the next calls need; ascending.
  [[nodiscard]] std::vector<int> watched(const Mesh& mesh) const;
  /// Nodes whose trial the review needs; ascending.
  [[nodiscard]] std::vector<int> loaded_nodes(const Mesh& mesh) const;

  /// A needle that is out of the tissue takes no part in a step, unless it goes in again.
  [[nodiscard]] bool takes_part(const NeedleStep& step) const {
    return !released() || step.speed() > 0;
  }
  /// Takes no part.
  void move_free(const NeedleStep& step) { tip_along_ = step.to; }
  void start_step(const Mesh& mesh, const NeedleStep& step);
  /// The same step from the same start, which ends sooner: its edits and contacts stay.
  void shorten_step(const NeedleStep& step) {
    step_ = step;
    forget_search();
  }
  [[nodiscard]] bool wants_edit() const { return hand_over_wanted_ || remaining_ != 0; }
  /// Throws NumericalError if the tip cannot go on.
  NeedleEdits plan(const Mesh& mesh, const NeedleView& start);
  [[nodiscard]] ConstraintSet constraints(const Mesh& mesh) const;
  /// True: the step is accepted. Throws NumericalError where the advance has no solution.
  bool review(const Mesh& mesh, const TrialView& trial, const Multiplier& lambda);
  /// start: the loaded nodes after the last edits; end_weight: of the forces at the end of the step in
  /// its work, those at its start have the rest.
  NeedleStepReport commit(const Mesh& mesh,
                          const NeedleView& start,
                          const TrialView& trial,
                          Multiplier lambda,
                          double end_weight = 1);

  [[nodiscard]] const NeedleParameters& parameters() const { return parameters_; }
  [[nodiscard]] const Axis& axis() const { return axis_; }
  /// Places along the axis (m): of the needle's own tip, and of the skin when it entered.
  [[nodiscard]] double tip() const { return tip_along_; }
  [[nodiscard]] double skin() const { return skin_along_; }
  [[nodiscard]] const Track& track() const { return track_; }
  [[nodiscard]] NeedlePhase phase() const { return phase_; }
  [[nodiscard]] TipContact tip_contact() const { return tip_; }
  /// Tip force (N) at which a tip that is in with all of its length cuts on, or punctures the membrane.
  [[nodiscard]] double force_to_cut(const Mesh& mesh) const {
    return membrane_ ? tissue_.puncture_force : whole_threshold(mesh);
  }
  [[nodiscard]] TipStand stand(const Mesh& mesh) const;
  [[nodiscard]] bool at_membrane() const { return membrane_.has_value(); }
  [[nodiscard]] const NeedleCounts& counts() const { return counts_; }
  /// Where the tip stands in the reference mesh: the end of the path, or the point of the path that
  /// a withdrawing tip has come back to.
  [[nodiscard]] ReferencePoint tip_point(const Mesh& mesh) const;
  /// True if every node of the path has been released.
  [[nodiscard]] bool released() const;

 private:
  enum class EndKind { hand_over, membrane, virgin };
  struct End {
    double b;
    EndKind kind;
  };
  [[nodiscard]] double radius() const { return 0.5 * parameters_.diameter; }
  [[nodiscard]] bool searches() const { return parameters_.cutting.law == CuttingLaw::consistent; }
  [[nodiscard]] double path_length(const Mesh& mesh) const;
  [[nodiscard]] bool presses_on_skin(const Mesh& mesh) const;
  [[nodiscard]] double whole_threshold(const Mesh& mesh) const;
  [[nodiscard]] double threshold(const Mesh& mesh) const;
  [[nodiscard]] double tolerance() const;
  [[nodiscard]] double slack() const;
  void puncture();
  void new_base();
  void forget_search();
  void forget_changes();
  void forget_block();
  [[nodiscard]] End find_end() const;
  [[nodiscard]] std::optional<double> crossing(double length) const;
  void pass_end();
  /// A place to be reached in one step would be a blow: the gap is left to later cuts.
  [[nodiscard]] bool holds_by_rate() const {
    return velocity_level_ && parameters_.cutting.law == CuttingLaw::lagged;
  }
  [[nodiscard]] double gap(const Mesh& mesh, const TrialView& trial) const;
  [[nodiscard]] std::vector<NodeShare> tip_shares(const Mesh& mesh) const;
  [[nodiscard]] std::vector<double> friction_lengths(const Mesh& mesh) const;
  bool review_friction(const Mesh& mesh, const TrialView& trial);
  bool review_tip(const Mesh& mesh, const TrialView& trial, const Multiplier& lambda);
  bool cut_further(double gap);
  [[noreturn]] void throw_no_solution() const;
  void check_tip(const Mesh& mesh, const TrialView& trial, double lambda) const;
  void book_work(const NeedleView& start,
                 const TrialView& trial,
                 std::vector<NodeForce> forces,
                 double end_weight,
                 NeedleStepReport& report);

  NeedleParameters parameters_;
  NeedleTissue tissue_;
  bool velocity_level_;
  Axis axis_;
  double tip_along_ = 0;
  double skin_along_ = 0;
  NeedleStep step_;
  NeedlePhase phase_ = NeedlePhase::outside;
  TipContact tip_ = TipContact::stick;
  Track track_;
  Skin skin_;           ///< around the entry, as far as the tip can press on it
  bool free_ = false;   ///< the tip moves where an earlier needle has cut
  double exposed_ = 0;  ///< length of the path ahead of a withdrawn tip (m)

  // The advance within the present step.
  std::optional<AdvanceBase> base_;
  double b_ = 0;          ///< applied from base_ (m)
  double remaining_ = 0;  ///< still to apply (m)
  bool hand_over_wanted_ = false;
  bool postponed_ = false;  ///< no node may become the tip yet: goes on to the end of its reach
  int passages_ = 0;        ///< flips in this step that made way for the tip
  double advanced_ = 0;     ///< over the whole step (m)
  double base_free_ = 0;    ///< advance from base_ that is cut already (m)
  std::optional<End> end_;  ///< of base_
  AdvanceSearch search_;
  std::optional<double> holds_beyond_;      ///< advance at which the search let the tip hold (m)
  std::optional<ReferencePoint> membrane_;  ///< where the tip stands at it, not yet punctured
  std::vector<ReferencePoint> punctures_;   ///< of this needle and those before
  double pending_ = 0;                      ///< advance left for the next step (lagged, m)
  double last_tip_force_ = 0;               ///< N
  std::vector<NodeForce> last_forces_;      ///< at the end of the last step
  std::size_t fewest_wrong_ = 0;            ///< contacts that had to change, on this mesh
  int patience_ = 0;
  int rounds_ = 0;           ///< of changes of the shaft's contacts in this step
  int contact_changes_ = 0;  ///< of the shaft in this step
  NeedleCounts counts_;
};

}  // namespace stylet
