#include "stylet/dynamics/explicit_step.hpp"

#include "stylet/base/lanes.hpp"

#include <algorithm>
#include <cstring>

namespace stylet {

namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

struct Vectors {
  Lanes x;
  Lanes y;
};

STYLET_INLINE Vectors gather(const double* field, const int* nodes) {
  Pair at_node[4];
  for (std::size_t l = 0; l < 4; ++l) {
    std::memcpy(&at_node[l], field + 2 * at(nodes[l]), sizeof(Pair));
  }
  const Lanes even = __builtin_shufflevector(at_node[0], at_node[2], 0, 1, 2, 3);
  const Lanes odd = __builtin_shufflevector(at_node[1], at_node[3], 0, 1, 2, 3);
  return {__builtin_shufflevector(even, odd, 0, 4, 2, 6),
          __builtin_shufflevector(even, odd, 1, 5, 3, 7)};
}

// One after the other, since the lanes may share nodes.
STYLET_INLINE void scatter(const Vectors& f, const int* nodes, double* field) {
  const Lanes even = __builtin_shufflevector(f.x, f.y, 0, 4, 2, 6);
  const Lanes odd = __builtin_shufflevector(f.x, f.y, 1, 5, 3, 7);
  const Pair at_node[4] = {
      __builtin_shufflevector(even, even, 0, 1), __builtin_shufflevector(odd, odd, 0, 1),
      __builtin_shufflevector(even, even, 2, 3), __builtin_shufflevector(odd, odd, 2, 3)};
  for (std::size_t l = 0; l < 4; ++l) {
    double* const to = field + 2 * at(nodes[l]);
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
  const Vectors last = gather(s, c.node[2]);
  Vectors first = gather(s, c.node[0]);
  Vectors second = gather(s, c.node[1]);
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
  scatter(first, c.node[0], force);
  scatter(second, c.node[1], force);
  scatter({-(first.x + second.x), -(first.y + second.y)}, c.node[2], force);
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

// Locals, since stores might change the structure.
STYLET_INLINE void predict_range(const ExplicitArrays& x,
                                 const ExplicitFactors& f,
                                 std::size_t begin,
                                 std::size_t end,
                                 std::span<const GivenPlace>& given,
                                 StepSums& sums) {
  const double half = 0.5 * f.h;
  const double h = f.h;
  const double stiffness_factor = f.stiffness_factor;
  const double* const mass = x.mass;
  const double* const u0 = x.u0;
  const double* const v0 = x.v0;
  const double* const a0 = x.a0;
  double* const u = x.u;
  double* const v = x.v;
  double* const a = x.a;
  double* const stretched = stiffness_factor != 0 ? x.stretched : nullptr;
  double start = 0;
  double middle = 0;
  for (std::size_t node = begin; node < end; ++node) {
    double of_start = 0;
    double of_middle = 0;
    for (std::size_t i = 2 * node; i < 2 * node + 2; ++i) {
      const double before = v0[i];
      const double now = before + half * a0[i];
      const double place = u0[i] + h * now;
      v[i] = now;
      u[i] = place;
      a[i] = 0;
      if (stretched != nullptr) stretched[i] = place + stiffness_factor * now;
      of_start += before * now;
      of_middle += now * now;
    }
    start += mass[node] * of_start;
    middle += mass[node] * of_middle;
  }
  for (; !given.empty() && given.front().dof < 2 * end; given = given.subspan(1)) {
    const auto [i, place] = given.front();
    const double m = mass[i / 2];
    const double now = (place - u0[i]) / h;
    const double squares = m * (now * now - v[i] * v[i]);
    sums.blow += 0.5 * squares;
    start += m * v0[i] * (now - v[i]);
    middle += squares;
    u[i] = place;
    v[i] = now;
    if (stretched != nullptr) stretched[i] = place + stiffness_factor * now;
  }
  sums.start += start;
  sums.half += middle;
}

STYLET_INLINE void accelerate_range(const ExplicitArrays& x,
                                    const ExplicitFactors& f,
                                    const double* force,
                                    std::size_t begin,
                                    std::size_t end,
                                    StepSums& sums) {
  const double* const load = x.load;
  const double* const inverse_root = x.inverse_root;
  double* const v = x.v;
  double* const a = x.a;
  const double half = 0.5 * f.h;
  const double mass_factor = f.mass_factor;
  const double damped = 1 / (1 + half * mass_factor);
  double by_load = 0;
  double by_rest = 0;
  for (std::size_t node = begin; node < end; ++node) {
    const std::size_t i = 2 * node;
    const double inverse = inverse_root[node] * inverse_root[node];
    const double v0 = v[i];
    const double v1 = v[i + 1];
    double rest0 = -force[i];
    double rest1 = -force[i + 1];
    if (load != nullptr) {
      rest0 += load[i];
      rest1 += load[i + 1];
      by_load += load[i] * v0 + load[i + 1] * v1;
    }
    const double a0 = (rest0 * inverse - mass_factor * v0) * damped;
    const double a1 = (rest1 * inverse - mass_factor * v1) * damped;
    a[i] = a0;
    a[i + 1] = a1;
    v[i] = v0 + half * a0;
    v[i + 1] = v1 + half * a1;
    by_rest += rest0 * v0 + rest1 * v1;
  }
  sums.load += by_load;
  sums.rest += by_rest;
}

// What comes next, group by group: hardware does not see ahead in streams that break off after each
// block, and large meshes take a quarter longer.
class Fetch {
 public:
  STYLET_INLINE Fetch(const ExplicitArrays& x, std::size_t node)
      : fields_{x.u0, x.v0, x.a0, x.u, x.v, x.a}, dof_(2 * node) {}
  STYLET_INLINE void next(const CellKernel::Group* group) {
    constexpr std::size_t ahead = 16;
    constexpr std::size_t cache_line = 64;
    const auto* const bytes = reinterpret_cast<const char*>(group + ahead);
    for (std::size_t i = 0; i < sizeof *group; i += cache_line) __builtin_prefetch(bytes + i);
    for (const double* field : fields_) __builtin_prefetch(field + dof_);
    dof_ += 4;  // two nodes for four triangles
  }

 private:
  const double* fields_[6];
  std::size_t dof_;
};

STYLET_INLINE std::size_t end_of(const ExplicitArrays& x, std::size_t k) {
  return std::min(x.n_nodes, (k + 1) * CellKernel::block);
}

STYLET_LANES void step_plain(const ExplicitArrays& x,
                             const ExplicitFactors& f,
                             const CellKernel& cells,
                             std::span<const GivenPlace> given,
                             StepSums& sums) {
  std::size_t predicted = 0;
  for (std::size_t k = 0; k < cells.n_blocks(); ++k) {
    if (cells.reach(k) > predicted) {
      predict_range(x, f, predicted, cells.reach(k), given, sums);
      predicted = cells.reach(k);
    }
    Fetch fetch(x, predicted);
    cells.groups_of(k, [&](std::size_t i) STYLET_INNER {
      const CellKernel::Group& c = cells.groups()[i];
      fetch.next(&c);
      const Gradient h = gradient(c, x.stretched);
      push(c, h, load_lanes(c.volume) * (h.xx + h.yy), x.a);
    });
    accelerate_range(x, f, x.a, k * CellKernel::block, end_of(x, k), sums);
  }
}

// A block's pressures are known once all blocks up to it have added their dilatation, its forces once
// all cells that its own cells' corners are in have pushed.
STYLET_LANES void step_averaged(const ExplicitArrays& x,
                                const ExplicitFactors& f,
                                const CellKernel& cells,
                                std::span<const GivenPlace> given,
                                double* pressure,
                                StepSums& sums) {
  const auto& stiffness = cells.stiffnesses();
  const auto& further = cells.further_patches();
  std::fill(pressure + x.n_nodes, pressure + stiffness.size(), 0.0);
  std::size_t predicted = 0;
  std::size_t next_further = 0;
  std::size_t pushed = 0;
  for (std::size_t k = 0; k < cells.n_blocks(); ++k) {
    if (cells.reach(k) > predicted) {
      predict_range(x, f, predicted, cells.reach(k), given, sums);
      std::fill(pressure + predicted, pressure + cells.reach(k), 0.0);
      predicted = cells.reach(k);
    }
    Fetch fetch(x, predicted);
    cells.groups_of(k, [&](std::size_t i) STYLET_INNER {
      fetch.next(cells.groups() + i);
      dilate(cells.groups()[i], cells.patches()[i], x.stretched, pressure);
    });
    const std::size_t end = end_of(x, k);
    for (std::size_t n = k * CellKernel::block; n < end; ++n) pressure[n] *= stiffness[n];
    for (; next_further < further.size() && at(further[next_further]) < end; ++next_further) {
      pressure[x.n_nodes + next_further] *= stiffness[x.n_nodes + next_further];
    }
    for (; pushed <= k && cells.reach(pushed) <= end; ++pushed) {
      cells.groups_of(pushed, [&](std::size_t i) STYLET_INNER {
        const CellKernel::Group& c = cells.groups()[i];
        push(c, gradient(c, x.stretched),
             load_lanes(c.volume) * pressures(cells.patches()[i], pressure), x.a);
      });
      accelerate_range(x, f, x.a, pushed * CellKernel::block, end_of(x, pushed), sums);
    }
  }
}

}  // namespace

void predict(const ExplicitArrays& x,
             const ExplicitFactors& f,
             std::span<const GivenPlace> given,
             StepSums& sums) {
  predict_range(x, f, 0, x.n_nodes, given, sums);
}

void accelerate(const ExplicitArrays& x,
                const ExplicitFactors& f,
                const double* force,
                StepSums& sums) {
  accelerate_range(x, f, force, 0, x.n_nodes, sums);
}

void step(const ExplicitArrays& x,
          const ExplicitFactors& f,
          const CellKernel& cells,
          std::span<const GivenPlace> given,
          std::vector<double>& pressure,
          StepSums& sums) {
  if (!cells.averaged()) {
    step_plain(x, f, cells, given, sums);
    return;
  }
  pressure.resize(cells.stiffnesses().size());
  step_averaged(x, f, cells, given, pressure.data(), sums);
}

}  // namespace stylet
