// The path of a needle in the reference mesh: what it has cut so far, and how the cut goes on.
//
// The tip's node stands at the end of the path and goes on from a base along a straight way: to the
// element's far edge at most, where another node takes its place (a hand-over), to a membrane, or to
// the end of what an earlier needle has cut. Those ends are the only places where the law of the tip
// has to be asked again. In 2D a point of the track is a node of the mesh, and an advance is an edit.
//
// Points are numbered from the skin, and keep their numbers and nodes; those of the skin beside the entry,
// which only the tip's load reaches, have negative ones.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/advance.hpp"
#include "stylet/needle/axis.hpp"
#include "stylet/needle/earlier_cuts.hpp"
#include "stylet/needle/parameters.hpp"
#include "stylet/needle/skin.hpp"
#include "stylet/needle/track.hpp"
#include "stylet/needle/track_view.hpp"
#include "stylet/needle/view.hpp"

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace stylet {

/// Properties that the needle meets in the tissue.
struct NeedleTissue {
  std::vector<ReferencePoint> membrane;  ///< polygon; empty if there is none
  double puncture_force = 0;             ///< N
  std::vector<double> region_modulus;    ///< Young's modulus by region (Pa), for stiffness_share
  EarlierCuts earlier;                   ///< of the needles before
};

struct NeedleCounts {
  int hand_overs = 0;
  int fallbacks = 0;  ///< advances along d because F was no help
  int punctures = 0;
};
[[nodiscard]] inline NeedleCounts operator+(const NeedleCounts& a, const NeedleCounts& b) {
  return {a.hand_overs + b.hand_overs, a.fallbacks + b.fallbacks, a.punctures + b.punctures};
}

class CutPath final : public TrackOperator {
 public:
  /// The mesh is lent. radius: within which earlier cuts and punctures are the needle's own (m);
  /// stops_at_ends: a tip that comes to the end of its base waits there for `pass_end`.
  CutPath(const Mesh& mesh,
          Axis axis,
          double tip_length,
          double radius,
          bool stops_at_ends,
          NeedleTissue tissue);

  /// The skin node slides to the axis; start: the two nodes of the entry. Returns the edit.
  NeedleEdits enter(const Entry& entry, const NeedleView& start);
  /// What later needles find: the earlier cuts and this one.
  [[nodiscard]] EarlierCuts leave() const;

  [[nodiscard]] const Axis& axis() const { return axis_; }
  [[nodiscard]] Track& track() { return track_; }
  [[nodiscard]] const Track& track() const { return track_; }
  /// m, from the skin to the deepest point.
  [[nodiscard]] double length() const { return track_.distances(mesh_).front(); }
  /// Distance of each point from the deepest one along the path (m), skin first.
  [[nodiscard]] std::vector<double> distances() const { return track_.distances(mesh_); }
  [[nodiscard]] ReferencePoint point(std::size_t i) const {
    return mesh_.point(track_.nodes()[i].node);
  }
  [[nodiscard]] ReferencePoint tip() const { return mesh_.point(track_.tip()); }
  /// The whole path is one skin point: nothing is cut yet.
  [[nodiscard]] bool is_uncut() const { return track_.size() == 1; }
  /// What lies ahead of the tip was cut by an earlier needle.
  [[nodiscard]] bool is_free() const { return free_; }
  [[nodiscard]] bool at_membrane() const { return membrane_.has_value(); }
  [[nodiscard]] double puncture_force() const { return tissue_.puncture_force; }
  /// Other numbers of the tissue from the next step on.
  void change(double puncture_force, std::vector<double> region_modulus) {
    tissue_.puncture_force = puncture_force;
    tissue_.region_modulus = std::move(region_modulus);
  }
  /// Share of the tip's length that is in the tissue.
  [[nodiscard]] double share_in() const;
  /// Young's modulus of the element furthest ahead of the tip (Pa).
  [[nodiscard]] double modulus_ahead() const;
  /// Size of the elements around the tip (m).
  [[nodiscard]] double element_size() const;
  /// Shares of the tip's load by point; they sum to 1.
  [[nodiscard]] std::vector<PointShare> tip_shares() const;
  /// Length of shaft (m) that each point stands for.
  [[nodiscard]] std::vector<double> shaft_lengths() const;
  /// Points that the needle may load, apart from those of before.
  [[nodiscard]] std::vector<int> loaded_points() const;
  [[nodiscard]] SparseRow row(TrackPlace place) const override { return {*dof(place)}; }
  /// Of a node.
  [[nodiscard]] std::optional<DofValue> dof(TrackPlace place) const override;
  /// Nodes whose state at the start of a step `plan` needs; ascending.
  [[nodiscard]] std::vector<int> watched() const;
  [[nodiscard]] const NeedleCounts& counts() const { return counts_; }

  // A needle that goes back.

  /// A tip that let go leaves the points that it has passed (paper, sec. V.E), and takes them again on its
  /// way back in. to: where the needle's tip is (m); speed: of the needle (m/s).
  void uncover(double to,
               const TrackTrial& trial,
               const std::optional<FrictionParameters>& friction,
               double speed);
  /// The tip touches the end of the path again: all points are the needle's.
  void cover();
  /// True if the needle has left every point.
  [[nodiscard]] bool is_released() const;
  /// Where the needle's tip stands in the reference mesh: the end of the path, or the point of the path
  /// that it has come back to.
  [[nodiscard]] ReferencePoint tip_point() const;

  /// A step begins whose tip wants to go on by `advance` (m).
  void start_step(double advance);
  /// m, in the present step.
  [[nodiscard]] double advanced() const { return advanced_; }
  /// m, from the present base.
  [[nodiscard]] double b() const { return b_; }
  /// The largest b of this base, if it is known yet.
  [[nodiscard]] std::optional<double> end() const;
  /// Counts bases: with another one the gap is another function of b.
  [[nodiscard]] int base() const { return n_bases_; }

  /// What the law of the tip wants; carried out by `plan`.
  void go_to(double b) { remaining_ = b - b_; }
  void go_on(double advance) { remaining_ = advance; }
  void begin_cut() { hand_over_wanted_ = true; }
  /// The tip has come to the end of its base and wants to go on. True if what is there holds it.
  bool pass_end();
  void puncture();
  /// The next plan looks for the way again, from where the tip then stands.
  void new_base();

  [[nodiscard]] bool wants_edit() const { return hand_over_wanted_ || remaining_ != 0; }
  struct Plan {
    NeedleEdits edits;
    bool holds = false;  ///< the tip came to where it must wait for its law
  };
  /// start: of the watched nodes. Throws Blocked if the tip cannot go on.
  Plan plan(const NeedleView& start);
  struct Blocked : std::runtime_error {
    using std::runtime_error::runtime_error;
  };

 private:
  enum class EndKind { hand_over, membrane, virgin };
  struct End {
    double b;
    EndKind kind;
  };
  [[nodiscard]] End find_end() const;
  [[nodiscard]] std::optional<double> crossing(double length) const;
  [[nodiscard]] int skin_point(int node) const;
  bool find_base(const NeedleView& start);
  Plan hand_over(const NeedleView& start);

  const Mesh& mesh_;
  Axis axis_;
  double tip_length_;
  double radius_;
  bool stops_at_ends_;
  NeedleTissue tissue_;
  Track track_;
  Skin skin_;                               ///< around the entry, as far as the tip can press on it
  bool free_ = false;                       ///< the tip moves where an earlier needle has cut
  std::optional<ReferencePoint> membrane_;  ///< where the tip stands at it, not yet punctured
  std::vector<ReferencePoint> punctures_;   ///< of this needle and those before
  NeedleCounts counts_;
  double exposed_ = 0;  ///< length of the path ahead of a withdrawn tip (m)

  // The advance within the present step.
  std::optional<AdvanceBase> base_;
  int n_bases_ = 0;
  double b_ = 0;          ///< applied from base_ (m)
  double remaining_ = 0;  ///< still to apply (m)
  bool hand_over_wanted_ = false;
  bool postponed_ = false;  ///< no node may become the tip yet: goes on to the end of its reach
  int passages_ = 0;        ///< flips in this step that made way for the tip
  double advanced_ = 0;     ///< over the whole step (m)
  double base_free_ = 0;    ///< advance from base_ that is cut already (m)
  std::optional<End> end_;  ///< of base_
};

}  // namespace stylet
