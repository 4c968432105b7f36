// Four triangles of the cell kernel at a time. Only for source files that are compiled for several
// machines (lanes.hpp).
#pragma once

#include "stylet/base/index.hpp"
#include "stylet/base/lanes.hpp"
#include "stylet/fem/cell_kernel.hpp"

#include <cstring>

namespace stylet::cell_lanes {

struct Vectors {
  Lanes x;
  Lanes y;
};

STYLET_INLINE Vectors gather(const double* field, const int* dofs) {
  Pair at_node[4];
  for (std::size_t l = 0; l < 4; ++l) {
    std::memcpy(&at_node[l], field + dofs[l], sizeof(Pair));
  }
  const Lanes even = __builtin_shufflevector(at_node[0], at_node[2], 0, 1, 2, 3);
  const Lanes odd = __builtin_shufflevector(at_node[1], at_node[3], 0, 1, 2, 3);
  return {__builtin_shufflevector(even, odd, 0, 4, 2, 6),
          __builtin_shufflevector(even, odd, 1, 5, 3, 7)};
}

// One after the other, since the lanes may share nodes.
STYLET_INLINE void scatter(const Vectors& f, const int* dofs, double* field) {
  const Lanes even = __builtin_shufflevector(f.x, f.y, 0, 4, 2, 6);
  const Lanes odd = __builtin_shufflevector(f.x, f.y, 1, 5, 3, 7);
  const Pair at_node[4] = {
      __builtin_shufflevector(even, even, 0, 1), __builtin_shufflevector(odd, odd, 0, 1),
      __builtin_shufflevector(even, even, 2, 3), __builtin_shufflevector(odd, odd, 2, 3)};
  for (std::size_t l = 0; l < 4; ++l) {
    double* const to = field + dofs[l];
    Pair sum;
    std::memcpy(&sum, to, sizeof sum);
    sum += at_node[l];
    std::memcpy(to, &sum, sizeof sum);
  }
}

/// Displacement gradient, times s: xx is s du_x/dx.
struct Gradient {
  Lanes g[4];
  Lanes xx, xy, yx, yy;
};

STYLET_INLINE Gradient gradient(const CellKernel::Group& c, const double* s) {
  const Vectors last = gather(s, c.dof[2]);
  Vectors first = gather(s, c.dof[0]);
  Vectors second = gather(s, c.dof[1]);
  first = {first.x - last.x, first.y - last.y};
  second = {second.x - last.x, second.y - last.y};
  const Lanes g0 = load_lanes(c.gradient[0]);
  const Lanes g1 = load_lanes(c.gradient[1]);
  const Lanes g2 = load_lanes(c.gradient[2]);
  const Lanes g3 = load_lanes(c.gradient[3]);
  return {{g0, g1, g2, g3},
          first.x * g0 + second.x * g2,
          first.x * g1 + second.x * g3,
          first.y * g0 + second.y * g2,
          first.y * g1 + second.y * g3};
}

// Of the stress  volumetric I + 2 eps, in units of s.
STYLET_INLINE void push(const CellKernel::Group& c,
                        const Gradient& h,
                        const Lanes& volumetric,
                        double* force) {
  const Lanes xx = volumetric + (h.xx + h.xx);
  const Lanes yy = volumetric + (h.yy + h.yy);
  const Lanes xy = h.xy + h.yx;
  const Vectors first = {xx * h.g[0] + xy * h.g[1], xy * h.g[0] + yy * h.g[1]};
  const Vectors second = {xx * h.g[2] + xy * h.g[3], xy * h.g[2] + yy * h.g[3]};
  scatter(first, c.dof[0], force);
  scatter(second, c.dof[1], force);
  scatter({-(first.x + second.x), -(first.y + second.y)}, c.dof[2], force);
}

// Adds  int phi_n div u  to the patches of the corners.
STYLET_INLINE void dilate(const CellKernel::Group& c,
                          const CellKernel::Patches& p,
                          const double* s,
                          double* dilatation) {
  const Gradient h = gradient(c, s);
  const Lanes share = load_lanes(c.volume) * (h.xx + h.yy);
  for (const auto& patches : p.patch) {
    for (std::size_t l = 0; l < 4; ++l) dilatation[at(patches[l])] += share[l];
  }
}

STYLET_INLINE Lanes pressures(const CellKernel::Patches& p, const double* pressure) {
  Lanes sum{};
  for (const auto& patches : p.patch) {
    const Lanes more = {pressure[at(patches[0])], pressure[at(patches[1])],
                        pressure[at(patches[2])], pressure[at(patches[3])]};
    sum += more;
  }
  return sum;
}

}  // namespace stylet::cell_lanes
