// Explicit Newmark (beta = 0, gamma = 1/2) as a registered PETSc TS type, driven through TSStep.
#pragma once

#include <petscts.h>

#include <functional>

namespace stylet {

/// Makes displacement and velocity after a step of length h (paper, sec. IV.B).
using ExplicitStep = std::function<void(double h, Vec u, Vec v)>;

inline constexpr const char* central_difference_type = "stylet-central-difference";

/// Registers the type; call once before TSSetType.
void register_central_difference();

void set_step(TS ts, ExplicitStep step);

}  // namespace stylet
