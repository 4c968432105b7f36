// How far a run is from small strain: the largest principal strain of any cell.
//
// At the tip of a needle, and in corners where a support ends, strain is the larger the finer the
// mesh, in every run, and says little of the rest. So a strain that has a limit is kept beside it: the
// one exceeded on a thousandth of the tissue, without what is near the needle. In the reference
// scene on four meshes the largest strain is 0.7, 1.3, 2.8, 4.9.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/track.hpp"

#include <array>
#include <span>

namespace stylet {

struct StrainPeak {
  double value = 0;  ///< absolute value, dimensionless
  double time = 0;   ///< s
  ReferencePlace place;
};

struct LargestStrain {
  StrainPeak anywhere;
  /// Exceeded on a thousandth of the area (3D: volume), further than a tip_length from the needle's path.
  StrainPeak widespread;
};

/// Triangles that the displacements turn over, as no tissue can be: det(I + grad u) <= 0, where one of the
/// principal strains of small-strain theory is below -1. The mesh of the undeformed tissue is as good as ever.
struct TurnedOver {
  int triangles = 0;  ///< at a time
  double area = 0;    ///< of them, undeformed (m^2)
  double time = 0;    ///< s
  double first = 0;   ///< s, when any was turned over
  ReferencePlace place;

  void add(const Mesh& mesh, int cell);
  void raise(const TurnedOver& seen) {
    if (seen.triangles <= triangles) return;
    const double since = triangles > 0 ? first : seen.time;
    *this = seen;
    first = since;
  }
};

/// displacements: of the cell's nodes (m).
[[nodiscard]] bool is_turned_over(const Mesh& mesh,
                                  int cell,
                                  const std::array<Vector2, 3>& displacements);

/// All triangles now. u: displacements of all dofs; time in s.
[[nodiscard]] TurnedOver turned_over(const Mesh& mesh, std::span<const double> u, double time);

/// Raises the peaks where this state exceeds them. u: displacements of all dofs; track: null without
/// a needle in the tissue.
void raise(LargestStrain& largest,
           const Mesh& mesh,
           std::span<const double> u,
           double time,
           const Track* track,
           double tip_length);

}  // namespace stylet
