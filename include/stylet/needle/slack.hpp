// What round-off of the solver is worth in decisions.
#pragma once

namespace stylet {

/// Relative slack of force thresholds.
constexpr double force_slack = 1e-9;

}  // namespace stylet
