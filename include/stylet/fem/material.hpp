// Isotropic linear elasticity in the plane and in space.
#pragma once

#include "stylet/fem/element.hpp"
#include "stylet/fem/parameters.hpp"

namespace stylet {

/// Moduli of the 2D element. Throws InputError for nu outside [0, 0.5) or E <= 0.
[[nodiscard]] Moduli plane_moduli(const LinearElastic& material, Plane plane);

/// Lame's moduli (3D, plane strain).
[[nodiscard]] Moduli lame_moduli(const LinearElastic& material);

/// Stress of a plane element (Pa).
struct PlaneStress {
  double xx = 0;
  double yy = 0;
  double xy = 0;
  double zz = 0;  ///< non-zero in plane strain

  [[nodiscard]] double von_mises() const;
};

/// h: displacement gradient; pressure: lambda tr(eps) (Pa), see TissueOperator::volumetric. In plane
/// strain sigma_zz is the pressure.
[[nodiscard]] PlaneStress plane_stress(const LinearSimplex<2>::Block& h,
                                       double mu,
                                       double pressure,
                                       Plane plane);

/// mu eps : eps, the strain energy per volume without its volumetric part (J/m^3).
[[nodiscard]] double shear_energy_density(const LinearSimplex<2>::Block& h, double mu);

}  // namespace stylet
