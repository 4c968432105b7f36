// What a mesh leaves out of a needle in space. The mesh carries the needle's force spread over the rings of
// a kernel; C adds on the track what lies between them and the needle's own surface:
//
//   C_kj = 1/(l_k l_j) int_k int_j [g_r(|s - s'|) - g_a(|s - s'|)] ds ds'
//
// g: Kelvin's solution over the one ring of radius r, and over the kernel's rings (kelvin_rings.hpp). Below
// a plane skin that is free and normal to the track Mindlin's image adds to g, at depths z and c,
//
//   along:   [(8 (1 - nu)^2 - (3 - 4 nu)) A + (3 - 4 nu) B + 2 z c A''] / (16 pi G (1 - nu))
//   across:  [(1 + (3 - 4 nu)/2 + 2 (1 - nu)(1 - 2 nu)) A - (3 - 4 nu)/2 B + z c A''] / (16 pi G (1 - nu))
//
// of s = z + c. Source: Mindlin, Physics 7 (1936) 195, averaged over the rings.
#pragma once

#include "stylet/needle/kelvin_rings.hpp"

#include <span>
#include <vector>

namespace stylet {

/// A piece of a straight track, between two distances from the skin (m).
struct TrackSegment {
  double from;
  double to;
  double shear_modulus;  ///< Pa, of the tissue around it
  double poisson_ratio;
  [[nodiscard]] double length() const { return to - from; }
};

/// A function of the distance of two rings, and its first and second primitive (0 at distance 0): tables
/// on a grid that is graded towards the logarithm at 0.
class RingPrimitives {
 public:
  struct Value {
    RingMeans twice;  ///< second primitive (m)
    RingMeans once;
    RingMeans mean;
  };

  /// Of the ring of this radius less the rings of a kernel, as far as a distance (m).
  RingPrimitives(double radius, std::span<const Ring> kernel, double reach);
  /// s: 0 to reach. The mean itself is not defined at 0, and 0 there.
  [[nodiscard]] Value at(double s) const;

 private:
  std::vector<double> s_;
  std::vector<Value> values_;
  RingMeans log_slope_;  ///< of the mean at 0
};

class RestCompliance {
 public:
  /// radius: of the needle (m); kernel: see kernel_rings; length: of the track (m); below_skin: with
  /// Mindlin's image.
  RestCompliance(double radius, std::span<const Ring> kernel, double length, bool below_skin);

  /// Mean displacement of one segment by a unit force on the other one or the same (m/N). Symmetric, and
  /// positive definite among segments that do not overlap (below a skin as soon as the kernel's effective
  /// radius is 5 % larger than the needle's). Of two materials it takes the geometric mean of shear moduli,
  /// and the mean of Poisson's ratios.
  [[nodiscard]] double along(const TrackSegment& a, const TrackSegment& b) const;
  [[nodiscard]] double across(const TrackSegment& a, const TrackSegment& b) const;

 private:
  struct Parts {
    RingMeans near;   ///< means of A and B of the distance
    RingMeans image;  ///< of the distance to the image
    double bent;      ///< of z c A''
  };
  [[nodiscard]] Parts parts(const TrackSegment& a, const TrackSegment& b) const;

  RingPrimitives primitives_;
  bool below_skin_;
};

}  // namespace stylet
