#include "stylet/mesh/line_through.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace stylet {

namespace {

// Round-off of a barycentric coordinate: cells overlap by so much of their size.
constexpr double on_face = 1e-9;
// What touches the tissue at a node or an edge is shorter than this part of a cell.
constexpr double touch = 1e-6;

std::optional<Stretch> within(const Mesh& mesh, int c, ReferencePlace start, Vector3 direction) {
  const auto t = mesh.tetrahedron(c);
  Stretch stretch{0, std::numeric_limits<double>::infinity(), c};
  for (std::size_t i = 0; i < 4; ++i) {
    const ReferencePlace a = t[(i + 1) % 4];
    const Vector3 normal = cross(t[(i + 2) % 4] - a, t[(i + 3) % 4] - a);
    const double height = dot(t[i] - a, normal);
    // The barycentric coordinate of this corner, and its change with the distance.
    const double at_start = dot(start - a, normal) / height + on_face;
    const double slope = dot(direction, normal) / height;
    if (slope == 0) {
      if (at_start < 0) return std::nullopt;
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
  std::optional<Stretch> first;
  for (const Stretch& piece : pieces) {
    if (first && piece.from <= first->to) {
      first->to = std::max(first->to, piece.to);
      continue;
    }
    if (first && first->to - first->from > touch * std::cbrt(mesh.cell_measure(first->cell))) break;
    first = piece;
  }
  if (first && first->to - first->from <= touch * std::cbrt(mesh.cell_measure(first->cell))) {
    first.reset();
  }
  return first;
}

}  // namespace stylet
