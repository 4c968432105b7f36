// What a needle's track feels of the tissue's displacements, and where its forces go:
//
//   ubar = B u + C lambda,   K u = f + B^T lambda
//
// A row of B is the displacement of a point of the track in one direction: of a node it is a unit vector,
// of a piece of track that lies within elements a mean over many dofs. C is the compliance that the mesh
// leaves out of such means; points that are nodes have none. Plain data: the needle makes it too.
#pragma once

#include <optional>
#include <vector>

namespace stylet {

struct DofValue {
  int dof;
  double value;
};

/// Sum of value times displacement of the dofs; each dof at most once.
using SparseRow = std::vector<DofValue>;

/// Directions of a needle: across_too in 3D only.
enum class Component { along, across, across_too };

/// A displacement, or a force, of the track.
struct TrackPlace {
  int point;
  Component component;
};

class TrackOperator {
 public:
  TrackOperator() = default;
  TrackOperator(const TrackOperator&) = default;
  TrackOperator& operator=(const TrackOperator&) = default;
  virtual ~TrackOperator() = default;

  /// Directions that there are.
  [[nodiscard]] virtual int n_components() const { return 2; }
  /// Of points that rows may be asked of; none: those that are nodes of a mesh.
  [[nodiscard]] virtual int n_points() const { return 0; }
  /// Row of B.
  [[nodiscard]] virtual SparseRow row(TrackPlace place) const = 0;
  /// The one entry of such a row; none if it has more. Asked for in every trial.
  [[nodiscard]] virtual std::optional<DofValue> dof(TrackPlace) const { return std::nullopt; }
  /// Entry of C (m/N), symmetric; between all rows of more than one dof it is positive definite, else 0.
  [[nodiscard]] virtual double rest(TrackPlace, TrackPlace) const { return 0; }
};

/// Where the solver hears of dofs, rows of more than one follow behind the mesh's own `n_dofs`.
[[nodiscard]] inline int coordinate_of(int n_dofs, TrackPlace place) {
  return n_dofs + 3 * place.point + static_cast<int>(place.component);
}
[[nodiscard]] inline TrackPlace place_of(int n_dofs, int coordinate) {
  const int row = coordinate - n_dofs;
  return {row / 3, static_cast<Component>(row % 3)};
}

}  // namespace stylet
