// Isotropic linear elasticity in the plane and in space.
#pragma once

#include "stylet/fem/element.hpp"
#include "stylet/fem/parameters.hpp"

namespace stylet {

/// Moduli of the element: of a plane one, or Lame's where there is no plane. Throws InputError for nu outside [0, 0.5) or E <= 0.
[[nodiscard]] Moduli moduli_of(const LinearElastic& material, std::optional<Plane> plane);

/// Lame's moduli (3D, plane strain).
[[nodiscard]] Moduli lame_moduli(const LinearElastic& material);

/// Stress of an element (Pa).
struct Stress {
  double xx = 0;
  double yy = 0;
  double xy = 0;
  double zz = 0;  ///< 0 in plane stress
  double yz = 0;  ///< in space only
  double zx = 0;

  [[nodiscard]] double von_mises() const;
};

/// h: displacement gradient; pressure: lambda tr(eps) (Pa), see TissueOperator::volumetric. In plane
/// strain sigma_zz is the pressure.
[[nodiscard]] Stress plane_stress(const LinearSimplex<2>::Block& h,
                                  double mu,
                                  double pressure,
                                  Plane plane);
/// The same of a tetrahedron.
[[nodiscard]] Stress space_stress(const LinearSimplex<3>::Block& h, double mu, double pressure);

/// mu eps : eps, the strain energy per volume without its volumetric part (J/m^3).
[[nodiscard]] double shear_energy_density(const LinearSimplex<2>::Block& h, double mu);
[[nodiscard]] double shear_energy_density(const LinearSimplex<3>::Block& h, double mu);

}  // namespace stylet
