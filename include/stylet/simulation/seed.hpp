// Seeds: where needles leave them, and where they may.
#pragma once

#include "stylet/needle/needle.hpp"
#include "stylet/simulation/body.hpp"

#include <string>

namespace stylet {

struct Seed {
  std::string needle;
  std::string target;    ///< empty if the scene has none
  double time = 0;       ///< of implantation (s)
  Vector3 displacement;  ///< of the tissue there when it was implanted (m)
  Riders place;          ///< one point
  TipStand tip;
  CuttingParameters cutting;  ///< of the needle
  int turned_over = 0;        ///< most triangles at a time, from when its needle entered
};

/// Why a needle cannot leave a seed where it stands; empty if it can. largest_tip_force: so far (N).
[[nodiscard]] std::string why_no_seed(const Needle& needle, double largest_tip_force);

/// Collective. Leaves a seed at the tip of a needle. largest_tip_force: of the needle so far (N), for
/// the message. Throws NumericalError where the needle has not cut its way there.
[[nodiscard]] Seed leave_seed(Body& body,
                              const Needle& needle,
                              const std::string& target,
                              double largest_tip_force);

}  // namespace stylet
