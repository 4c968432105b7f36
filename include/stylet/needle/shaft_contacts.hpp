// Stick and slip along the shaft within a step: which points change, and that this ends.
#pragma once

#include "stylet/needle/contact_work.hpp"
#include "stylet/needle/parameters.hpp"
#include "stylet/needle/track.hpp"
#include "stylet/needle/track_view.hpp"

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace stylet {

/// All contacts change at once where they must, which is fast and may cycle. So on a mesh that has not
/// changed for long, points that have slid have one limit of force for sticking and sliding: that is
/// Tresca's problem, which has one solution, and block pivoting finds it (Portugal, Judice and Vicente
/// 1994): all that must change as long as they get fewer, else the last one alone.
///
/// A search moves the tip and begins this anew. After many rounds the points that have slid keep their
/// one limit for the rest of the step, and can only become more: for each set of them the gap is a
/// continuous function of the advance, which the search does not forget any more and brackets in finitely
/// many steps.
class ShaftContacts {
 public:
  enum class Verdict {
    agree,       ///< with the trial
    change,      ///< some did; the gap at the tip is the function that it was
    change_gap,  ///< some did; it is another one
  };

  void start_step(Track& track);
  /// The mesh is about to change.
  void forget_changes(Track& track);
  /// lengths: of shaft that the points stand for (m), zero where there is no friction; speed: of the
  /// needle (m/s).
  Verdict review(Track& track,
                 std::span<const double> lengths,
                 const TrackTrial& trial,
                 const FrictionParameters& law,
                 double speed);
  struct Shaft {
    double force = 0;  ///< N, on the tissue along the axis
    int n_stick = 0;
    int n_slip = 0;
  };
  /// The step is accepted: adds to the forces on points; points that slide slowly stick from now on.
  Shaft commit(Track& track,
               std::span<const double> lengths,
               const TrackTrial& trial,
               const FrictionParameters& law,
               double speed,
               std::vector<PointForce>& forces) const;
  /// In this step.
  [[nodiscard]] int changes() const { return changes_; }

 private:
  [[nodiscard]] bool is_careful(const Track& track) const;
  void forget_block();
  void choose(std::vector<std::size_t>& wrong);

  std::size_t fewest_wrong_ = std::numeric_limits<std::size_t>::max();
  int patience_ = 0;
  int rounds_ = 0;  ///< of changes in this step
  int changes_ = 0;
};

}  // namespace stylet
