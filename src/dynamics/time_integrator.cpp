#include "stylet/dynamics/time_integrator.hpp"

#include <stdexcept>

namespace stylet {

static constexpr const char* no_rows = "this time integrator takes no rows of a track";

void TimeIntegrator::follow(const TrackOperator&) {
  throw std::logic_error(no_rows);
}

void TimeIntegrator::leave_track() {}

RowTrial TimeIntegrator::row(int) const {
  throw std::logic_error(no_rows);
}

}  // namespace stylet
