// The track of a needle in space: a straight way through the mesh, which stays as it is. What a segment of
// it feels is a mean over the rings of a kernel that the mesh can resolve, and what the mesh leaves out of
// that, in closed form (rest_compliance.hpp). A point of the track is a segment, counted from the skin.
#pragma once

#include "stylet/geometry/points.hpp"
#include "stylet/mesh/cell_grid.hpp"
#include "stylet/mesh/line_through.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/rest_compliance.hpp"
#include "stylet/needle/track_view.hpp"
#include "stylet/solvers/track_operator.hpp"

#include <array>
#include <utility>
#include <vector>

namespace stylet {

/// Of the tissue of a region.
struct RegionModuli {
  double shear_modulus;  ///< Pa
  double poisson_ratio;
};

struct TrackLayout {
  double radius;         ///< of the needle (m)
  double kernel_radius;  ///< m, see kernel_rings
  double segment;        ///< length of one (m); the last one has what is left, 0.5 to 1.5 of it
  int rings = 8;         ///< of the kernel
  /// The skin is a free plane as far as the kernel reaches, normal to the needle. Up to 40 degrees from
  /// that the image of a normal one is right to 0.2 % of a stuck needle's force.
  bool below_skin = false;
};

/// Two unit vectors across a direction, and each other.
[[nodiscard]] std::pair<Vector3, Vector3> across_of(Vector3 direction);

class EmbeddedTrack final : public TrackOperator {
 public:
  /// The line from `start` (at or before the skin) in `direction` (of any length but 0), as far as `depth`
  /// behind the skin (m), or to where it leaves the tissue. regions: one each of the mesh's. Throws
  /// InputError for a line that begins inside the tissue or misses it, and for a kernel that is mostly
  /// outside of it.
  EmbeddedTrack(const Mesh& mesh,
                ReferencePlace start,
                Vector3 direction,
                double depth,
                const TrackLayout& layout,
                const std::vector<RegionModuli>& regions);

  [[nodiscard]] int size() const { return static_cast<int>(segments_.size()); }
  [[nodiscard]] const TrackSegment& segment(int point) const {
    return segments_[static_cast<std::size_t>(point)];
  }
  /// Of the mesh, at the middle of a segment.
  [[nodiscard]] int cell(int point) const { return cells_[static_cast<std::size_t>(point)]; }
  /// Where the line crosses the skin.
  [[nodiscard]] ReferencePlace skin() const { return skin_; }
  /// Unit vector; those across are normal to the track and to each other.
  [[nodiscard]] Vector3 direction(Component component) const {
    return axes_[static_cast<std::size_t>(component)];
  }
  [[nodiscard]] ReferencePlace at(double depth) const { return skin_ + depth * axes_[0]; }

  /// Mean of the displacement's component over the kernel along the segment: two stations at Gauss points,
  /// rings of points half a mean edge apart, six at least. Those outside the tissue are left out, and the
  /// others stand in for them.
  [[nodiscard]] SparseRow row(TrackPlace place) const override;
  [[nodiscard]] double rest(TrackPlace a, TrackPlace b) const override;
  [[nodiscard]] int n_components() const override { return 3; }
  [[nodiscard]] int n_points() const override { return size(); }

  /// Of a load that is even between two depths (m, on the track): how its segments share it.
  [[nodiscard]] std::vector<PointShare> shares(double from, double to) const;
  /// Segments that the load covers in part bear it over all of their length. Its mean displacement along
  /// the needle by a unit of it is larger than theirs by this (m/N): nothing where it ends with segments.
  [[nodiscard]] double rest_of_ends(double from, double to) const;

 private:
  EmbeddedTrack(const Mesh& mesh,
                ReferencePlace start,
                const std::array<Vector3, 3>& axes,
                const Stretch& stretch,
                const TrackLayout& layout,
                const std::vector<RegionModuli>& regions);

  struct NodeShare {
    int node;
    double share;
  };
  [[nodiscard]] std::vector<NodeShare> mean_over(const Mesh& mesh,
                                                 const CellGrid& grid,
                                                 const TrackSegment& segment,
                                                 std::span<const Ring> rings,
                                                 double spacing) const;

  ReferencePlace skin_;
  std::array<Vector3, 3> axes_;
  std::vector<TrackSegment> segments_;
  std::vector<int> cells_;
  std::vector<std::vector<NodeShare>> shares_;  ///< of each segment, by node
  RestCompliance rest_;
  // Entries of C between segments: [a * size() + b].
  std::vector<double> rest_along_;
  std::vector<double> rest_across_;
};

}  // namespace stylet
