// Explicit Newmark (beta = 0, gamma = 1/2) as a registered PETSc TS type, driven through TSStep.
#pragma once

#include <petscts.h>

#include <functional>

namespace stylet {

/// a = acceleration at time t for displacement u and the velocity v + h/2 a0 (paper, sec. IV.B). May
/// set prescribed entries of u.
using Acceleration = std::function<void(double t, Vec u, Vec v_half, Vec a)>;

inline constexpr const char* central_difference_type = "stylet-central-difference";

/// Registers the type; call once before TSSetType.
void register_central_difference();

/// Collective. The function and the vector that holds the acceleration from step to step.
void set_acceleration(TS ts, Acceleration acceleration, Vec a);

}  // namespace stylet
