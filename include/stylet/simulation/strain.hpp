// How far a run is from small strain: the largest principal strain of any triangle.
//
// At the tip of a needle strain is large in every run, on any scale that a mesh resolves, and says
// little of the rest; so the largest strain away from the needle is kept beside it.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/track.hpp"

#include <span>

namespace stylet {

struct StrainPeak {
  double value = 0;  ///< absolute value, dimensionless
  double time = 0;   ///< s
  ReferencePoint place;
};

struct LargestStrain {
  StrainPeak anywhere;
  StrainPeak away;  ///< in triangles further than a tip_length from the needle's path
};

/// Raises the peaks where this state exceeds them. u: displacements of all dofs; track: null without
/// a needle in the tissue.
void raise(LargestStrain& largest,
           const Mesh& mesh,
           std::span<const double> u,
           double time,
           const Track* track,
           double tip_length);

}  // namespace stylet
