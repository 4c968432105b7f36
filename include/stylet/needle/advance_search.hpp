// The search for the advance of a tip that cuts: how far from its base it goes in a step.
//
// At an advance b the tip carries its threshold force; g(b) is what the needle is then ahead of it.
// The tip stops at the first b with g = 0. So the search comes from below, never goes beyond the end
// of its base before it has seen g > 0 there, and the caller passes one end at a time (a hand-over, a
// membrane): what lies behind an end that was never reached is never looked at.
#pragma once

#include <optional>

namespace stylet {

class AdvanceSearch {
 public:
  enum class Verdict {
    found,  ///< the tip stands at its threshold
    move,   ///< try the advance `b`
    pass,   ///< g > 0 at the end of the base: what is there has to give way
    stick,  ///< at `b` the threshold is more than the needle brings: the tip holds there
  };
  struct Next {
    Verdict verdict;
    double b;
  };

  /// g at b has been found, both in m; b = 0 is where the base begins, `end` the largest b, none if
  /// it is not known yet.
  Next next(double b, double g, std::optional<double> end, double tolerance);

  /// Another base, other contacts: g is another function.
  void forget() { *this = {}; }

  struct Sample {
    double b;
    double g;
  };
  [[nodiscard]] const std::optional<Sample>& too_short() const { return too_short_; }
  [[nodiscard]] const std::optional<Sample>& too_far() const { return too_far_; }

 private:
  std::optional<Sample> last_;
  std::optional<Sample> too_short_;  ///< the farthest with g > 0 before too_far_
  std::optional<Sample> too_far_;    ///< the nearest with g < 0
  int same_side_ = 0;                ///< samples in a row that were too short
  double width_ = 0;                 ///< of the bracket that they make
  int misses_ = 0;                   ///< times in a row that it did not halve
};

}  // namespace stylet
