// Sides of the cells of a mesh as it was read: which are outer ones, and what hangs together by the others.
#pragma once

#include "stylet/mesh/mesh_data.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace stylet {

/// Edges of triangles (Dim 2), faces of tetrahedra (3), by their nodes.
template <std::size_t Dim>
struct Sides {
  using Side = std::array<int, Dim>;
  /// Of one cell, as that one has it: seen from outside, counter-clockwise in space.
  std::vector<Side> outer;
  /// Of a cell: a cell of the part that it belongs to, the same for all of that part.
  std::vector<int> part;
};

/// Corners of a cell's sides.
template <std::size_t Dim>
inline constexpr std::array<std::array<int, Dim>, Dim + 1> corners_of_sides{};
template <>
inline constexpr std::array<std::array<int, 2>, 3> corners_of_sides<2>{{{0, 1}, {1, 2}, {2, 0}}};
template <>
inline constexpr std::array<std::array<int, 3>, 4> corners_of_sides<3>{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// A side that more than two cells have is joined in pairs, the cells of lower numbers first.
template <std::size_t Dim>
Sides<Dim> sides_of(const MeshData& mesh) {
  using Side = typename Sides<Dim>::Side;
  struct Of {
    Side key;
    Side side;
    int cell;
  };
  std::vector<Of> all;
  all.reserve(mesh.cells.size());
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  for (int c = 0; c < mesh.n_cells(); ++c) {
    for (const auto& corners : corners_of_sides<Dim>) {
      Of& next = all.emplace_back(Of{{}, {}, c});
      for (std::size_t k = 0; k < Dim; ++k) {
        next.side[k] = mesh.cells[(Dim + 1) * at(c) + at(corners[k])];
      }
      next.key = next.side;
      std::ranges::sort(next.key);
    }
  }
  std::ranges::sort(all, {}, [](const Of& s) { return std::pair(s.key, s.cell); });
  Sides<Dim> sides;
  sides.part.resize(at(mesh.n_cells()));
  std::iota(sides.part.begin(), sides.part.end(), 0);
  auto& part = sides.part;
  const auto root = [&](int c) {
    for (; part[at(c)] != c; c = part[at(c)]) part[at(c)] = part[at(part[at(c)])];
    return c;
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i + 1 < all.size() && all[i].key == all[i + 1].key) {
      part[at(root(all[i + 1].cell))] = root(all[i].cell);
      ++i;
    } else {
      sides.outer.push_back(all[i].side);
    }
  }
  for (int c = 0; c < mesh.n_cells(); ++c) part[at(c)] = root(c);
  return sides;
}

}  // namespace stylet
