// A needle that bends: a cantilever of Euler and Bernoulli from a guide outside the skin, whose flexibility joins
// the compliance of the track.
#pragma once

#include "stylet/needle/embedded_track.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace stylet {

struct Cantilever {
  double stiffness;  ///< E I (N m^2)
  double outside;    ///< length between guide and skin (m)
};

/// Mean deflection (m/N) of one piece by a unit force that is spread over the other one; depths from the skin.
/// By virtual work: int m_a m_b / (E I), m: moment of a load that is spread over a piece.
inline double flexibility(const Cantilever& beam, const TrackSegment& a, const TrackSegment& b) {
  const auto moment = [](const TrackSegment& piece, double s) {
    const double to = std::max(piece.to - s, 0.0);
    const double from = std::max(piece.from - s, 0.0);
    return (to * to - from * from) / (2 * piece.length());
  };
  // Between these the integrand is of the fourth degree at most, which three points of Gauss integrate exactly.
  std::array<double, 5> ends{-beam.outside, a.from, a.to, b.from, b.to};
  std::sort(ends.begin() + 1, ends.end());
  constexpr std::array<std::pair<double, double>, 3> gauss{
      {{0.1127016653792583, 5.0 / 18}, {0.5, 8.0 / 18}, {0.8872983346207417, 5.0 / 18}}};
  double sum = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const double length = ends[i] - ends[i - 1];
    for (const auto& [x, weight] : gauss) {
      const double s = ends[i - 1] + x * length;
      sum += weight * length * moment(a, s) * moment(b, s);
    }
  }
  return sum / beam.stiffness;
}

/// Tissue and needle in a row: what it takes to move a segment across, if the needle is pushed from its guide.
class BentTrack final : public TrackOperator {
 public:
  BentTrack(const EmbeddedTrack& track, const Cantilever& beam) : track_(track), beam_(beam) {}

  [[nodiscard]] int n_components() const override { return track_.n_components(); }
  [[nodiscard]] int n_points() const override { return track_.n_points(); }
  [[nodiscard]] SparseRow row(TrackPlace place) const override { return track_.row(place); }
  [[nodiscard]] double rest(TrackPlace a, TrackPlace b) const override {
    const double of_track = track_.rest(a, b);
    if (a.component != b.component || a.component == Component::along) return of_track;
    return of_track + flexibility(beam_, track_.segment(a.point), track_.segment(b.point));
  }

 private:
  const EmbeddedTrack& track_;
  Cantilever beam_;
};

}  // namespace stylet
