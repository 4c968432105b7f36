// How time is stepped.
#pragma once

namespace stylet {

enum class TimeMethod { implicit_newmark, explicit_newmark, quasi_static };
enum class ImplicitScheme { average_acceleration, generalised_alpha, backward_euler };

struct TimeParameters {
  TimeMethod method = TimeMethod::implicit_newmark;
  ImplicitScheme scheme = ImplicitScheme::backward_euler;
  double rho_infinity = 0.8;  ///< of generalised-alpha: spectral radius at h -> infinity, in [0, 1]
  double step = 1e-3;         ///< s; explicit steps are cut to the stable step
  double duration = 0;        ///< s; of a scene without a needle
  bool until_implanted = false;  ///< end at the last implant where that is exact
  double safety = 0.9;           ///< explicit: step / stable step
};

}  // namespace stylet
