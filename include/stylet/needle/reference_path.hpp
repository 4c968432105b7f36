// The path of a needle in the reference tissue: what it has cut so far, and how the cut goes on.
//
// The tip stands at the end of the path and goes on from a base along a straight way to the end of that base
// at most. Such ends are the only places where the law of the tip has to be asked again: where another point
// of the path begins (a hand-over), at a membrane, and at the end of what an earlier needle has cut. In the
// plane a point is a node of the mesh, and an advance is an edit (cut_path.hpp); in space it is a segment of
// a track, and the mesh stays as it is (embedded_path.hpp).
//
// Points are numbered from the skin, and keep their numbers; those of the skin beside the entry, which only
// the tip's load reaches, have negative ones.
#pragma once

#include "stylet/geometry/points.hpp"
#include "stylet/needle/advance.hpp"
#include "stylet/needle/earlier_cuts.hpp"
#include "stylet/needle/parameters.hpp"
#include "stylet/needle/surface_crossings.hpp"
#include "stylet/needle/track.hpp"
#include "stylet/needle/track_view.hpp"
#include "stylet/needle/view.hpp"

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace stylet {

/// Properties that the needle meets in the tissue.
struct NeedleTissue {
  std::vector<ReferencePoint> membrane;           ///< polygon; empty if there is none
  std::vector<SurfaceTriangle> membrane_surface;  ///< in space
  double puncture_force = 0;                      ///< N
  std::vector<double> region_modulus;  ///< Young's modulus by region (Pa), for stiffness_share
  EarlierCuts earlier;                 ///< of the needles before
};

struct NeedleCounts {
  long long hand_overs = 0;
  long long fallbacks = 0;  ///< advances along d because F was no help
  long long punctures = 0;
};
[[nodiscard]] inline NeedleCounts operator+(const NeedleCounts& a, const NeedleCounts& b) {
  return {a.hand_overs + b.hand_overs, a.fallbacks + b.fallbacks, a.punctures + b.punctures};
}

void archive(Archive& archive, NeedleCounts& counts);

class ReferencePath : public TrackOperator {
 public:
  /// The tip cannot go on.
  struct Blocked : std::runtime_error {
    using std::runtime_error::runtime_error;
  };

  // What there is of it.

  [[nodiscard]] Track& track() { return track_; }
  [[nodiscard]] const Track& track() const { return track_; }
  /// m, from the skin to the deepest point.
  [[nodiscard]] virtual double length() const = 0;
  /// Place of the deepest point along the axis (m).
  [[nodiscard]] virtual double tip_along() const = 0;
  /// The whole path is one skin point: nothing is cut yet.
  [[nodiscard]] virtual bool is_uncut() const = 0;
  /// The next cut is the first one, and goes ahead as far as the mesh lets it, whatever the force.
  [[nodiscard]] virtual bool jumps_ahead() const { return false; }
  /// The path is such a cut.
  [[nodiscard]] virtual bool is_first_cut() const { return false; }
  /// The point of the needle's axis at a place along it.
  [[nodiscard]] virtual WorldPlace on_axis(double along) const = 0;
  /// Where the needle's tip stands in the reference mesh: the end of the path, or the point of the path
  /// that it has come back to.
  [[nodiscard]] virtual ReferencePlace tip_point() const = 0;
  /// A cell there, or near it.
  [[nodiscard]] virtual int tip_cell() const = 0;
  /// The points of the path in the reference mesh, skin first, as far as the end.
  [[nodiscard]] virtual std::vector<ReferencePlace> line() const = 0;
  [[nodiscard]] const NeedleCounts& counts() const { return counts_; }

  // What the laws ask.

  /// What lies ahead of the tip was cut by an earlier needle.
  [[nodiscard]] bool is_free() const { return free_; }
  [[nodiscard]] virtual bool at_membrane() const = 0;
  [[nodiscard]] double puncture_force() const { return tissue_.puncture_force; }
  /// Other numbers of the tissue from the next step on.
  void change(double puncture_force, std::vector<double> region_modulus);
  /// Share of the tip's length that is in the tissue.
  [[nodiscard]] double share_in() const;
  /// Young's modulus of the element furthest ahead of the tip (Pa).
  [[nodiscard]] virtual double modulus_ahead() const = 0;
  /// Size of the elements around the tip (m).
  [[nodiscard]] virtual double element_size() const = 0;
  /// Shares of the tip's load by point; they sum to 1.
  [[nodiscard]] virtual std::vector<PointShare> tip_shares() const = 0;
  /// By a unit of its load the tip moves further than its points do (m/N).
  [[nodiscard]] virtual double tip_rest() const { return 0; }
  /// Length of shaft (m) that each point stands for.
  [[nodiscard]] virtual std::vector<double> shaft_lengths() const = 0;
  /// Points that the needle may load, apart from those of before.
  [[nodiscard]] virtual std::vector<int> loaded_points() const = 0;
  /// Adds what keeps a point on the needle's axis.
  virtual void guide(int point, std::vector<TrackHold>& held) const = 0;

  // A needle that goes back.

  /// A tip that let go leaves the points that it has passed (paper, sec. V.E), and takes them again on its
  /// way back in. to: where the needle's tip is (m); speed: of the needle (m/s).
  virtual void uncover(double to,
                       const TrackTrial& trial,
                       const std::optional<FrictionParameters>& friction,
                       double speed) = 0;
  /// The tip touches the end of the path again: all points are the needle's.
  void cover();
  /// True if the needle has left every point.
  [[nodiscard]] bool is_released() const;

  // The advance in a step.

  /// The skin node slides to the axis; start: the two nodes of the entry. Returns the edit. Of the plane only.
  virtual NeedleEdits enter(const Entry& entry, const NeedleView& start);
  /// What later needles find: the earlier cuts and this one.
  [[nodiscard]] EarlierCuts leave() const;
  /// Nodes whose state at the start of a step `plan` needs; ascending.
  [[nodiscard]] virtual std::vector<int> watched() const { return {}; }

  /// A step begins whose tip wants to go on by `advance` (m).
  virtual void start_step(double advance);
  /// m, in the present step.
  [[nodiscard]] double advanced() const { return advanced_; }
  /// m, from the present base.
  [[nodiscard]] double b() const { return b_; }
  /// The largest b of this base, if it is known yet.
  [[nodiscard]] std::optional<double> end() const {
    return end_ ? std::optional(end_->b) : std::nullopt;
  }
  /// Counts bases: with another one the gap is another function of b.
  [[nodiscard]] long long base() const { return n_bases_; }

  /// What the law of the tip wants; carried out by `plan`.
  void go_to(double b) { remaining_ = b - b_; }
  /// Where it jumps ahead.
  virtual void begin_cut() {}
  /// The tip has come to the end of its base and wants to go on. True if what is there holds it.
  virtual bool pass_end() = 0;
  virtual void puncture() = 0;
  /// The next plan looks for the way again, from where the tip then stands.
  virtual void new_base() = 0;

  [[nodiscard]] virtual bool wants_edit() const { return remaining_ != 0; }
  struct Plan {
    NeedleEdits edits;
    bool holds = false;  ///< the tip came to where it must wait for its law
  };
  /// Throws Blocked.
  virtual Plan plan(const NeedleView& start) = 0;

  /// Between steps.
  virtual void archive(Archive& archive) = 0;

 protected:
  /// radius: within which earlier cuts and punctures are the needle's own (m); stops_at_ends: a tip that
  /// comes to the end of its base waits there for `pass_end`.
  ReferencePath(double tip_length, double radius, bool stops_at_ends, NeedleTissue tissue)
      : tip_length_(tip_length),
        radius_(radius),
        stops_at_ends_(stops_at_ends),
        tissue_(std::move(tissue)),
        punctures_(tissue_.earlier.punctures) {}

  /// What ends a base: where another point of the path begins, the membrane, uncut tissue behind an earlier
  /// needle's cut, the end of the track.
  enum class EndKind { hand_over, membrane, virgin, track };
  struct End {
    double b;
    EndKind kind;
  };

  /// The tip stands at the membrane, which gives way there.
  void puncture_at(const ReferencePlace& x);
  /// Takes what remains of the advance as far as the end of the base allows: go(b) brings the tip there.
  void carry_out(const std::function<void(double)>& go, Plan& plan);

  /// Nearer than this to the end of an earlier cut the tip is there (m).
  static constexpr double touching = 1e-9;

  /// Takes a point again, or leaves it.
  static void attach(ShaftNode& shaft,
                     bool attached,
                     const PointTrial& trial,
                     const std::optional<FrictionParameters>& friction,
                     double speed);

  double tip_length_;
  double radius_;
  bool stops_at_ends_;
  NeedleTissue tissue_;
  Track track_;
  bool free_ = false;  ///< the tip moves where an earlier needle has cut
  NeedleCounts counts_;
  double exposed_ = 0;                     ///< length of the path ahead of a withdrawn tip (m)
  std::vector<ReferencePlace> punctures_;  ///< of this needle and those before

  // The advance within the present step.
  long long n_bases_ = 0;
  double b_ = 0;            ///< applied from the base (m)
  double remaining_ = 0;    ///< still to apply (m)
  double advanced_ = 0;     ///< over the whole step (m)
  std::optional<End> end_;  ///< of the base
};

}  // namespace stylet
