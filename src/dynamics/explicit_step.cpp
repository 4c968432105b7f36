#include "stylet/dynamics/explicit_step.hpp"

#include "stylet/base/index.hpp"
#include "stylet/base/lanes.hpp"
#include "stylet/fem/cell_lanes.hpp"

#include <algorithm>
#include <array>

namespace stylet {

namespace {

using namespace cell_lanes;

// Calls each(first dof, lanes) for nodes two by two, then for one that is left.
template <class Each>
STYLET_INLINE void in_pairs(std::size_t begin, std::size_t end, Each&& each) {
  std::size_t node = begin;
  for (; node + 2 <= end; node += 2) each(2 * node, Lanes{});
  if (node < end) each(2 * node, Pair{});
}

// clears: forces too.
template <bool clears>
STYLET_INLINE void predict_range(const ExplicitArrays& x,
                                 const ExplicitFactors& f,
                                 std::size_t begin,
                                 std::size_t end,
                                 std::span<const GivenPlace>& given,
                                 StepSums& sums) {
  const double half = 0.5 * f.h;
  const double h = f.h;
  const double stiffness_factor = f.stiffness_factor;
  Lanes start{};
  Lanes middle{};
  in_pairs(begin, end, [&]<class V>(std::size_t i, V) STYLET_INNER {
    const V before = load_lanes<V>(x.v0 + i);
    const V now = before + half * load_lanes<V>(x.a0 + i);
    const V place = load_lanes<V>(x.u0 + i) + h * now;
    store_lanes(x.v + i, now);
    store_lanes(x.u + i, place);
    if constexpr (clears) store_lanes(x.force + i, V{});
    if (x.stretched != x.u) store_lanes(x.stretched + i, place + stiffness_factor * now);
    const V momentum = load_twice<V>(x.mass + i / 2) * now;
    add_lanes(start, before * momentum);
    add_lanes(middle, now * momentum);
  });
  sums.start += sum_of(start);
  sums.half += sum_of(middle);
  for (; !given.empty() && given.front().dof < 2 * end; given = given.subspan(1)) {
    const auto [i, place] = given.front();
    const double m = x.mass[i / 2];
    const double now = (place - x.u0[i]) / h;
    const double squares = m * (now * now - x.v[i] * x.v[i]);
    sums.blow += 0.5 * squares;
    sums.start += m * x.v0[i] * (now - x.v[i]);
    sums.half += squares;
    x.u[i] = place;
    x.v[i] = now;
    if (x.stretched != x.u) x.stretched[i] = place + stiffness_factor * now;
  }
}

STYLET_INLINE void accelerate_range(const ExplicitArrays& x,
                                    const ExplicitFactors& f,
                                    std::size_t begin,
                                    std::size_t end,
                                    StepSums& sums) {
  const double half = 0.5 * f.h;
  const double mass_factor = f.mass_factor;
  const double damped = 1 / (1 + half * mass_factor);
  Lanes of_load{};
  Lanes of_rest{};
  in_pairs(begin, end, [&]<class V>(std::size_t i, V) STYLET_INNER {
    const V root = load_twice<V>(x.inverse_root + i / 2);
    const V before = load_lanes<V>(x.v + i);
    V rest = -load_lanes<V>(x.force + i);
    if (x.load != nullptr) {
      const V load = load_lanes<V>(x.load + i);
      rest += load;
      add_lanes(of_load, load * before);
    }
    const V a = (rest * (root * root) - mass_factor * before) * damped;
    store_lanes(x.a + i, a);
    store_lanes(x.v + i, before + half * a);
    add_lanes(of_rest, rest * before);
  });
  sums.load += sum_of(of_load);
  sums.rest += sum_of(of_rest);
}

// What comes next, group by group: hardware does not see ahead in streams that break off after each
// block, and large meshes take a quarter longer.
class Fetch {
 public:
  /// Fields from where each will be read next.
  STYLET_INLINE explicit Fetch(std::array<const double*, 6> fields) : fields_(fields) {}
  STYLET_INLINE void next(const CellKernel::Group* group) {
    constexpr std::size_t ahead = 16;
    constexpr std::size_t cache_line = 64;
    const auto* const bytes = reinterpret_cast<const char*>(group + ahead);
    for (std::size_t i = 0; i < sizeof *group; i += cache_line) __builtin_prefetch(bytes + i);
    for (const double* field : fields_) __builtin_prefetch(field + offset_);
    offset_ += 4;  // two nodes for four triangles
  }

 private:
  std::array<const double*, 6> fields_;
  std::size_t offset_ = 0;
};

STYLET_INLINE std::size_t end_of(std::size_t k, std::size_t n_nodes) {
  return std::min(n_nodes, (k + 1) * CellKernel::block);
}

/// Prepares nodes as far as a block of triangles reads them: predicts them, or if that has been done
/// clears their forces.
class Front {
 public:
  STYLET_INLINE explicit Front(bool predicted) : predicted_(predicted) {}
  STYLET_INLINE void advance(const ExplicitArrays& x,
                             const ExplicitFactors& f,
                             std::size_t reach,
                             std::span<const GivenPlace>& given,
                             StepSums& sums) {
    if (reach <= done_) return;
    if (predicted_) {
      std::fill(x.force + 2 * done_, x.force + 2 * reach, 0.0);
    } else {
      predict_range<true>(x, f, done_, reach, given, sums);
    }
    done_ = reach;
  }
  [[nodiscard]] STYLET_INLINE Fetch fetch(const ExplicitArrays& x, std::size_t k) const {
    const std::size_t i = 2 * done_;
    if (!predicted_) return Fetch({x.u0 + i, x.v0 + i, x.a0 + i, x.u + i, x.v + i, x.a + i});
    const std::size_t next = 2 * (k + 1) * CellKernel::block;
    return Fetch({x.stretched + i, x.force + i, x.v + next, x.a + next, x.inverse_root + next / 2,
                  x.inverse_root + next / 2});
  }

 private:
  bool predicted_;
  std::size_t done_ = 0;
};

STYLET_INLINE void accelerate_block(const ExplicitArrays& x,
                                    const ExplicitFactors& f,
                                    std::size_t k,
                                    StepSums& sums) {
  const std::size_t begin = k * CellKernel::block;
  if (begin < x.n_nodes) accelerate_range(x, f, begin, end_of(k, x.n_nodes), sums);
}

STYLET_LANES void pass_plain(const ExplicitArrays& x,
                             const ExplicitFactors& f,
                             const CellKernel& cells,
                             std::span<const GivenPlace> given,
                             bool predicted,
                             StepSums& sums) {
  Front front(predicted);
  for (std::size_t k = 0; k < cells.n_blocks(); ++k) {
    front.advance(x, f, cells.reach(k), given, sums);
    Fetch fetch = front.fetch(x, k);
    cells.groups_of(k, [&](std::size_t i) STYLET_INNER {
      const CellKernel::Group& c = cells.groups()[i];
      fetch.next(&c);
      const Gradient h = gradient(c, x.stretched);
      push(c, h, load_lanes(c.volume) * (h.xx + h.yy), x.force);
    });
    accelerate_block(x, f, k, sums);
  }
}

// A block's pressures are known once all blocks up to it have added their dilatation, its forces once
// all cells that its own cells' corners are in have pushed.
STYLET_LANES void pass_averaged(const ExplicitArrays& x,
                                const ExplicitFactors& f,
                                const CellKernel& cells,
                                std::span<const GivenPlace> given,
                                bool predicted,
                                double* pressure,
                                StepSums& sums) {
  const auto& stiffness = cells.stiffnesses();
  const auto& further = cells.further_patches();
  const std::size_t n_nodes = cells.nodes().n_all();
  std::fill(pressure + n_nodes, pressure + stiffness.size(), 0.0);
  Front front(predicted);
  std::size_t cleared = 0;
  std::size_t next_further = 0;
  std::size_t pushed = 0;
  for (std::size_t k = 0; k < cells.n_blocks(); ++k) {
    front.advance(x, f, cells.reach(k), given, sums);
    for (; cleared < cells.reach(k); ++cleared) pressure[cleared] = 0;
    Fetch fetch = front.fetch(x, k);
    cells.groups_of(k, [&](std::size_t i) STYLET_INNER {
      fetch.next(cells.groups() + i);
      dilate(cells.groups()[i], cells.patches()[i], x.stretched, pressure);
    });
    const std::size_t end = end_of(k, n_nodes);
    for (std::size_t n = k * CellKernel::block; n < end; ++n) pressure[n] *= stiffness[n];
    for (; next_further < further.size() && at(further[next_further]) < end; ++next_further) {
      pressure[n_nodes + next_further] *= stiffness[n_nodes + next_further];
    }
    for (; pushed <= k && cells.reach(pushed) <= end; ++pushed) {
      cells.groups_of(pushed, [&](std::size_t i) STYLET_INNER {
        const CellKernel::Group& c = cells.groups()[i];
        push(c, gradient(c, x.stretched),
             load_lanes(c.volume) * pressures(cells.patches()[i], pressure), x.force);
      });
      accelerate_block(x, f, pushed, sums);
    }
  }
}

void pass(const ExplicitArrays& x,
          const ExplicitFactors& f,
          const CellKernel& cells,
          std::span<const GivenPlace> given,
          bool predicted,
          std::vector<double>& pressure,
          StepSums& sums) {
  if (!cells.averaged()) {
    pass_plain(x, f, cells, given, predicted, sums);
    return;
  }
  pressure.resize(cells.stiffnesses().size());
  pass_averaged(x, f, cells, given, predicted, pressure.data(), sums);
}

}  // namespace

void predict(const ExplicitArrays& x,
             const ExplicitFactors& f,
             std::span<const GivenPlace> given,
             StepSums& sums) {
  predict_range<false>(x, f, 0, x.n_nodes, given, sums);
}

void accelerate(const ExplicitArrays& x,
                const ExplicitFactors& f,
                const CellKernel& cells,
                std::vector<double>& pressure,
                StepSums& sums) {
  pass(x, f, cells, {}, true, pressure, sums);
}

void step(const ExplicitArrays& x,
          const ExplicitFactors& f,
          const CellKernel& cells,
          std::span<const GivenPlace> given,
          std::vector<double>& pressure,
          StepSums& sums) {
  pass(x, f, cells, given, false, pressure, sums);
}

}  // namespace stylet
