// What the tissue is made of.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace stylet {

enum class Plane { stress, strain };
/// p1: the paper's triangle; p1_averaged: its dilatation is averaged around the nodes, so that it does
/// not lock (volume_patch.hpp).
enum class Formulation { p1, p1_averaged };
enum class MassKind { consistent, lumped };

struct LinearElastic {
  double youngs_modulus = 0;  ///< Pa
  double poisson_ratio = 0;
  double density = 0;  ///< kg/m^3
};

/// True where plain triangles resist a change of shape by several times too much in plane strain.
inline bool locks_in_plane_strain(const LinearElastic& material) {
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
  Plane plane = Plane::stress;
  double thickness = 0.01;  ///< out of plane (m)
  Formulation formulation = Formulation::p1;
  MassKind mass = MassKind::consistent;
  std::vector<RegionTissue> regions;
  std::optional<RayleighDamping> damping;
};

}  // namespace stylet
