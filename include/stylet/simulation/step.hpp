// One step of time: the needle's contacts and cuts and the tissue's motion, found together.
#pragma once

#include "stylet/needle/needle.hpp"
#include "stylet/simulation/body.hpp"
#include "stylet/simulation/hand.hpp"

namespace stylet {

struct SubStep {
  double h = 0;              ///< s
  long long passes = 0;      ///< solves tried
  long long iterations = 0;  ///< of KSP
  NeedleStepReport needle;
};

/// Collective. At most `longest` (s). needle: null where none is in. Throws NumericalError when the
/// step has no valid answer.
SubStep take_step(Body& body, Hand& hand, Needle* needle, double longest);

}  // namespace stylet
