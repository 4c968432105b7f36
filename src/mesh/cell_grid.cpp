#include "stylet/mesh/cell_grid.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

namespace {

// A point on a face is inside both of its cells, up to round-off of the barycentric coordinates.
constexpr double on_face = 1e-9;

}  // namespace

CellGrid::CellGrid(const Mesh& mesh, ReferencePlace low, ReferencePlace high, double spacing)
    : mesh_(mesh), low_(low), spacing_(spacing) {
  const Index last = index_of(high);
  size_ = {last[0] + 1, last[1] + 1, last[2] + 1};
  cells_.resize(box(last) + 1);
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto t = mesh.tetrahedron(c);
    Index from = index_of(t[0]);
    Index to = from;
    for (const ReferencePlace corner : t) {
      const Index at = index_of(corner);
      for (std::size_t k = 0; k < 3; ++k) {
        from[k] = std::min(from[k], at[k]);
        to[k] = std::max(to[k], at[k]);
      }
    }
    for (std::size_t k = 0; k < 3; ++k) {
      from[k] = std::max(from[k], 0);
      to[k] = std::min(to[k], size_[k] - 1);
    }
    for (int i = from[0]; i <= to[0]; ++i) {
      for (int j = from[1]; j <= to[1]; ++j) {
        for (int k = from[2]; k <= to[2]; ++k) cells_[box({i, j, k})].push_back(c);
      }
    }
  }
}

CellGrid::Index CellGrid::index_of(ReferencePlace x) const {
  const Vector3 v = x - low_;
  return {static_cast<int>(std::floor(v.x / spacing_)),
          static_cast<int>(std::floor(v.y / spacing_)),
          static_cast<int>(std::floor(v.z / spacing_))};
}

bool CellGrid::holds(const Index& i) const {
  return std::ranges::all_of(std::array{0, 1, 2}, [&](int axis) {
    const auto k = static_cast<std::size_t>(axis);
    return i[k] >= 0 && i[k] < size_[k];
  });
}

std::size_t CellGrid::box(const Index& i) const {
  return static_cast<std::size_t>(i[0]) +
         static_cast<std::size_t>(size_[0]) *
             (static_cast<std::size_t>(i[1]) +
              static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(i[2]));
}

std::optional<EmbeddedPoint> CellGrid::find(ReferencePlace x) const {
  const Index i = index_of(x);
  if (!holds(i)) return std::nullopt;
  for (const int c : cells_[box(i)]) {
    const auto weights = barycentric(mesh_.tetrahedron(c), x);
    if (std::ranges::min(weights) >= -on_face) return EmbeddedPoint{x, c, weights};
  }
  return std::nullopt;
}

}  // namespace stylet
