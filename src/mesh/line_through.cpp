#include "stylet/mesh/line_through.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace stylet {

namespace {

// Round-off of a barycentric coordinate: a line whose one changes by less within a cell is parallel to a face.
constexpr double on_face = 1e-9;
// Of the size of a cell: smaller gaps are round-off, and shorter stretches touch the tissue.
constexpr double touch = 1e-6;

double size_of(const Mesh& mesh, int c) {
  return std::cbrt(mesh.cell_measure(c));
}

std::optional<Stretch> within(const Mesh& mesh, int c, ReferencePlace start, Vector3 direction) {
  const auto t = mesh.tetrahedron(c);
  const double size = size_of(mesh, c);
  Stretch stretch{0, std::numeric_limits<double>::infinity(), c};
  for (std::size_t i = 0; i < 4; ++i) {
    const ReferencePlace a = t[(i + 1) % 4];
    const Vector3 normal = cross(t[(i + 2) % 4] - a, t[(i + 3) % 4] - a);
    const double height = dot(t[i] - a, normal);
    // The barycentric coordinate of this corner, and its change with the distance.
    const double at_start = dot(start - a, normal) / height;
    const double slope = dot(direction, normal) / height;
    if (std::abs(slope) * size < on_face) {
      if (at_start < -on_face) return std::nullopt;
      continue;
    }
    double& end = slope > 0 ? stretch.from : stretch.to;
    end = slope > 0 ? std::max(end, -at_start / slope) : std::min(end, -at_start / slope);
  }
  if (stretch.from >= stretch.to) return std::nullopt;
  return stretch;
}

}  // namespace

std::optional<Stretch> first_stretch(const Mesh& mesh, ReferencePlace start, Vector3 direction) {
  std::vector<Stretch> pieces;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (const auto piece = within(mesh, c, start, direction)) pieces.push_back(*piece);
  }
  std::ranges::stable_sort(pieces, {}, &Stretch::from);
  const auto touches = [&](const Stretch& stretch) {
    return stretch.to - stretch.from <= touch * size_of(mesh, stretch.cell);
  };
  std::optional<Stretch> first;
  for (const Stretch& piece : pieces) {
    if (first && piece.from <= first->to + touch * size_of(mesh, piece.cell)) {
      first->to = std::max(first->to, piece.to);
      continue;
    }
    if (first && !touches(*first)) break;
    first = piece;
  }
  if (first && touches(*first)) first.reset();
  return first;
}

}  // namespace stylet
