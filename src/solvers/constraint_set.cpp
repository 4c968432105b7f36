#include "stylet/solvers/constraint_set.hpp"

#include "stylet/base/errors.hpp"

namespace stylet {

void throw_all_held() {
  throw NumericalError("the tip condition cannot be met: every node of the tip is held");
}

}  // namespace stylet
