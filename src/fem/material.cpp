#include "stylet/fem/material.hpp"

#include "stylet/base/errors.hpp"

#include <cmath>
#include <string>

namespace stylet {

Moduli lame_moduli(const LinearElastic& material) {
  const double e = material.youngs_modulus;
  const double nu = material.poisson_ratio;
  if (!(e > 0) || !(nu >= 0) || !(nu < 0.5)) {
    throw InputError("material needs youngs_modulus > 0 and 0 <= poisson_ratio < 0.5, not " +
                     std::to_string(e) + " Pa and " + std::to_string(nu));
  }
  return {e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu))};
}

Moduli moduli_of(const LinearElastic& material, std::optional<Plane> plane) {
  Moduli m = lame_moduli(material);
  if (plane == Plane::stress) {
    m.lambda = material.youngs_modulus * material.poisson_ratio /
               (1 - material.poisson_ratio * material.poisson_ratio);
  }
  return m;
}

double Stress::von_mises() const {
  return std::sqrt(0.5 * ((xx - yy) * (xx - yy) + (yy - zz) * (yy - zz) + (zz - xx) * (zz - xx)) +
                   3 * xy * xy + 3 * yz * yz + 3 * zx * zx);
}

Stress plane_stress(const LinearSimplex<2>::Block& h, double mu, double pressure, Plane plane) {
  Stress s;
  s.xx = pressure + 2 * mu * h[0][0];
  s.yy = pressure + 2 * mu * h[1][1];
  s.xy = mu * (h[0][1] + h[1][0]);
  s.zz = plane == Plane::strain ? pressure : 0.0;
  return s;
}

Stress space_stress(const LinearSimplex<3>::Block& h, double mu, double pressure) {
  const auto normal = [&](std::size_t i) { return pressure + 2 * mu * h[i][i]; };
  const auto shear = [&](std::size_t i, std::size_t k) { return mu * (h[i][k] + h[k][i]); };
  return {normal(0), normal(1), shear(0, 1), normal(2), shear(1, 2), shear(2, 0)};
}

double shear_energy_density(const LinearSimplex<2>::Block& h, double mu) {
  const double shear = h[0][1] + h[1][0];
  return mu * (h[0][0] * h[0][0] + h[1][1] * h[1][1] + 0.5 * shear * shear);
}

double shear_energy_density(const LinearSimplex<3>::Block& h, double mu) {
  double squares = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double strain = 0.5 * (h[i][k] + h[k][i]);
      squares += strain * strain;
    }
  }
  return mu * squares;
}

}  // namespace stylet
