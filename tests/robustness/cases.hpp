// What is run on the meshes: needle heights, motions, methods and tips.
#pragma once

#include "stylet/scene/scene.hpp"

#include "meshes.hpp"

#include <string>
#include <vector>

namespace stylet::robustness {

enum class MotionKind {
  straight,   ///< in, seed, out
  reversals,  ///< back and forth in mid-element, a seed, out
  shiver,     ///< twelve reversals of half an element
  tiny,       ///< a first cut of 1 % of an element, out, in again
  holds,      ///< pauses while cutting and while stuck
  seeds,      ///< seeds on the way out, then deeper again
};

struct Case {
  std::string name;
  NamedMesh mesh;
  std::vector<double> heights;  ///< of the needles (m)
  MotionKind motion = MotionKind::straight;
  TimeMethod method = TimeMethod::quasi_static;
  double tip_length = 0;  ///< m
  CuttingLaw law = CuttingLaw::consistent;
  bool friction = true;
  bool membrane = false;       ///< around the region 'inner'
  double step = 0.02;          ///< s; 0.4 mm of insertion
  double depth = 0.045;        ///< m, of the deepest point
  double cutting_force = 1.7;  ///< N
  double poisson_ratio = 0.45;
  bool may_be_refused = false;  ///< too close to a corner of the tissue for its elements
};

[[nodiscard]] Scene scene_of(const Case& what);

/// The cases that every build runs (under a minute), and all of them (an hour).
[[nodiscard]] std::vector<Case> quick_cases(const std::vector<NamedMesh>& meshes);
[[nodiscard]] std::vector<Case> full_cases(const std::vector<NamedMesh>& meshes);
/// Anything at random, on the meshes with edges above 1.5 mm.
[[nodiscard]] std::vector<Case> random_cases(const std::vector<NamedMesh>& meshes,
                                             int n,
                                             unsigned seed);

[[nodiscard]] const char* name_of(MotionKind kind);
[[nodiscard]] const char* name_of(TimeMethod method);

}  // namespace stylet::robustness
