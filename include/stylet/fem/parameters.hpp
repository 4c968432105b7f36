// What the tissue is made of.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace stylet {

enum class Plane { stress, strain };
/// p1: the paper's triangle, or the linear tetrahedron; p1_averaged: its dilatation is averaged around the
/// nodes, so that it does not lock (volume_patch.hpp); p2: the quadratic tetrahedron, in space.
enum class Formulation { p1, p1_averaged, p2 };
enum class MassKind { consistent, lumped };

struct LinearElastic {
  double youngs_modulus = 0;  ///< Pa
  double poisson_ratio = 0;
  double density = 0;  ///< kg/m^3
};

/// True where plain cells resist a change of shape by several times too much in plane strain or space.
inline bool locks(const LinearElastic& material) {
  return material.poisson_ratio > 0.45;
}

/// C = mass_factor M + stiffness_factor K.
struct RayleighDamping {
  double mass_factor = 0;       ///< 1/s
  double stiffness_factor = 0;  ///< s
};

struct RegionTissue {
  std::string region;
  LinearElastic material;
};

struct TissueParameters {
  std::optional<Plane> plane = Plane::stress;  ///< none: tetrahedra in space
  double thickness = 0.01;                     ///< out of plane (m); in space it counts for nothing
  Formulation formulation = Formulation::p1;
  MassKind mass = MassKind::consistent;
  std::vector<RegionTissue> regions;
  std::optional<RayleighDamping> damping;

  [[nodiscard]] int dim() const { return plane ? 2 : 3; }
  /// What makes volumes of measures of cells: the thickness (m), or 1 in space.
  [[nodiscard]] double depth() const { return plane ? thickness : 1; }
};

}  // namespace stylet
