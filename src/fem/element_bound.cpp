#include "stylet/fem/tissue_operator.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace stylet {

double TissueOperator::element_bound(const Mesh& mesh, int cell) const {
  const auto n = mesh.cell(cell);
  const LinearSimplex<2> element(
      {mesh.coordinates(n[0]), mesh.coordinates(n[1]), mesh.coordinates(n[2])});
  const auto m = material(cell);
  std::array<std::array<double, 6>, 6> k{};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      const auto block = element.stiffness(a, b, m.moduli);
      for (std::size_t i = 0; i < 2; ++i) {
        for (std::size_t j = 0; j < 2; ++j) k[2 * a + i][2 * b + j] = block[i][j];
      }
    }
  }
  // (sum lambda^16)^(1/16) by three squarings: K_e has rank 3, so at most 3^(1/16) too high.
  double scale = 1;
  double exponent = 1;
  for (int squaring = 0; squaring < 3; ++squaring) {
    double largest = 0;
    for (const auto& row : k) {
      for (const double value : row) largest = std::max(largest, std::abs(value));
    }
    scale *= std::pow(largest, 1 / exponent);
    std::array<std::array<double, 6>, 6> square{};
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < 6; ++j) {
        for (std::size_t l = 0; l < 6; ++l) {
          square[i][j] += k[i][l] / largest * (k[l][j] / largest);
        }
      }
    }
    k = square;
    exponent *= 2;
  }
  double frobenius = 0;
  for (const auto& row : k) {
    for (const double value : row) frobenius += value * value;
  }
  const double largest = scale * std::pow(frobenius, 1 / (2 * exponent));
  return largest / (m.density * element.lumped_mass());
}

}  // namespace stylet
