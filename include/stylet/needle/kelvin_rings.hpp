// Kelvin's solution (a force within an endless elastic body) averaged over coaxial rings, of which one is
// pushed and the other one felt. In the symbols used here
//
//   along:   [(3 - 4 nu) A + B] / (16 pi G (1 - nu))             A: mean of 1/R
//   across:  [(3 - 4 nu) A + (A - B)/2] / (16 pi G (1 - nu))     B: mean of s^2/R^3
//
// R: distance of two points of the rings, s: of their planes. Source of Kelvin's solution: Love, A treatise
// on the mathematical theory of elasticity, 1927, section 130; the mean of x^2 is that of (R^2 - s^2)/2.
#pragma once

#include <span>
#include <vector>

namespace stylet {

/// Linear: those of several rings are sums.
struct RingMeans {
  double inverse = 0;  ///< A (1/m)
  double axial = 0;    ///< B (1/m)
  friend RingMeans operator+(RingMeans a, RingMeans b) {
    return {a.inverse + b.inverse, a.axial + b.axial};
  }
  friend RingMeans operator-(RingMeans a, RingMeans b) {
    return {a.inverse - b.inverse, a.axial - b.axial};
  }
  friend RingMeans operator*(double factor, RingMeans a) {
    return {factor * a.inverse, factor * a.axial};
  }
};

/// Of rings with radii a and b (m, positive) in planes at a distance s (m; not 0 if a = b), by complete
/// elliptic integrals.
[[nodiscard]] RingMeans ring_means(double s, double a, double b);

/// 1 / (16 pi G (1 - nu))
[[nodiscard]] double kelvin_factor(double shear_modulus, double poisson_ratio);
/// Displacement of a ring by a unit force along its axis, or across it, on the other one (m/N), or what has
/// become of both by linear operations. shear_modulus: Pa.
[[nodiscard]] double kelvin_along(RingMeans means, double shear_modulus, double poisson_ratio);
[[nodiscard]] double kelvin_across(RingMeans means, double shear_modulus, double poisson_ratio);

/// A ring of a kernel, or of the needle's own surface.
struct Ring {
  double radius;  ///< m
  double weight;  ///< share of the force; those of a kernel sum to 1
};

/// The uniform disc of a radius (m) by n rings: radius sqrt(t) with the points t and weights of Gauss and
/// Legendre on (0, 1). Ascending.
[[nodiscard]] std::vector<Ring> disc_rings(double radius, int n);

/// The rings over which a needle's force is spread: n of the disc of kernel_radius, or the needle's own
/// surface where that is wider. Throws InputError for a kernel that is wider than the needle but moves like
/// a narrower one.
[[nodiscard]] std::vector<Ring> kernel_rings(double kernel_radius, double radius, int n);

/// Means over all pairs of these rings.
[[nodiscard]] RingMeans ring_means(double s, std::span<const Ring> rings);

/// The ring (m) that a long needle with these rings moves like: its logarithm is the mean of that of the
/// larger radius of a pair. A uniform disc has e^(-1/4) of its radius.
[[nodiscard]] double effective_radius(std::span<const Ring> rings);

}  // namespace stylet
