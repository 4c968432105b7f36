// Whether tissue comes to rest, and if not, that it never will.
#pragma once

#include "stylet/base/archive.hpp"

namespace stylet {

/// Follows the largest speed of the tissue from step to step. Where it falls so slowly that the
/// tolerance is 300,000 steps away, three times in a row over longer and longer blocks of steps,
/// there is no waiting for it: undamped tissue swings for ever, and round-off has a floor.
class Settling {
 public:
  /// Another settle begins, or what acts on the tissue is still changing.
  void restart() { *this = {}; }
  /// Once a step. True at rest; throws NumericalError if that will not be.
  bool is_settled(double speed, double tolerance);
  void archive(Archive& archive);

 private:
  static constexpr long first_block = 500;

  long block_ = first_block;  ///< steps
  long step_ = 0;             ///< in the block
  double first_half_ = 0;     ///< largest speed in it (m/s)
  double second_half_ = 0;
  int hopeless_blocks_ = 0;  ///< in a row
};

}  // namespace stylet
