#include "stylet/fem/cell_operator.hpp"

#include "stylet/fem/cell_lanes.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>

namespace stylet {

namespace {

using namespace cell_lanes;

/// Fields of local nodes. mz: null if there is no mass to multiply with.
struct Product {
  const double* x;
  const double* z;
  double* kx;
  double* mz;
};

// m (z_a + sum of the corners), m a twelfth of the triangle's mass.
STYLET_INLINE void push_mass(const CellKernel::Group& c, const double* mass, const Product& p) {
  const Lanes m = load_lanes(mass);
  const Vectors z[3] = {gather(p.z, c.dof[0]), gather(p.z, c.dof[1]), gather(p.z, c.dof[2])};
  const Lanes x = z[0].x + z[1].x + z[2].x;
  const Lanes y = z[0].y + z[1].y + z[2].y;
  for (std::size_t a = 0; a < 3; ++a) {
    scatter({m * (z[a].x + x), m * (z[a].y + y)}, c.dof[a], p.mz);
  }
}

/// Clears what a block of triangles pushes, just before it does.
class Clear {
 public:
  STYLET_INLINE void to(std::size_t reach, const Product& p) {
    if (reach <= done_) return;
    std::fill(p.kx + 2 * done_, p.kx + 2 * reach, 0.0);
    if (p.mz != nullptr) std::fill(p.mz + 2 * done_, p.mz + 2 * reach, 0.0);
    done_ = reach;
  }

 private:
  std::size_t done_ = 0;
};

template <bool with_mass>
STYLET_INLINE void plain(const CellKernel& cells, const Product& p) {
  Clear clear;
  for (std::size_t k = 0; k < cells.n_blocks(); ++k) {
    clear.to(cells.reach(k), p);
    cells.groups_of(k, [&](std::size_t i) STYLET_INNER {
      const CellKernel::Group& c = cells.groups()[i];
      const Gradient h = gradient(c, p.x);
      push(c, h, load_lanes(c.volume) * (h.xx + h.yy), p.kx);
      if constexpr (with_mass) push_mass(c, cells.masses() + CellKernel::lanes * i, p);
    });
  }
}

// A block's pressures are known once all blocks up to it have added their dilatation.
template <bool with_mass>
STYLET_INLINE void averaged(const CellKernel& cells, const Product& p, double* pressure) {
  const auto& stiffness = cells.stiffnesses();
  const auto& further = cells.further_patches();
  const std::size_t n_nodes = cells.nodes().n_all();
  std::fill(pressure, pressure + stiffness.size(), 0.0);
  Clear clear;
  std::size_t next_further = 0;
  std::size_t pushed = 0;
  for (std::size_t k = 0; k < cells.n_blocks(); ++k) {
    clear.to(cells.reach(k), p);
    cells.groups_of(k, [&](std::size_t i) STYLET_INNER {
      dilate(cells.groups()[i], cells.patches()[i], p.x, pressure);
    });
    const std::size_t end = std::min(n_nodes, (k + 1) * CellKernel::block);
    for (std::size_t n = k * CellKernel::block; n < end; ++n) pressure[n] *= stiffness[n];
    for (; next_further < further.size() && at(further[next_further]) < end; ++next_further) {
      pressure[n_nodes + next_further] *= stiffness[n_nodes + next_further];
    }
    for (; pushed <= k && cells.reach(pushed) <= end; ++pushed) {
      cells.groups_of(pushed, [&](std::size_t i) STYLET_INNER {
        const CellKernel::Group& c = cells.groups()[i];
        push(c, gradient(c, p.x), load_lanes(c.volume) * pressures(cells.patches()[i], pressure),
             p.kx);
        if constexpr (with_mass) push_mass(c, cells.masses() + CellKernel::lanes * i, p);
      });
    }
  }
}

STYLET_LANES void plain_stiffness(const CellKernel& cells, const Product& p) {
  plain<false>(cells, p);
}
STYLET_LANES void plain_both(const CellKernel& cells, const Product& p) {
  plain<true>(cells, p);
}
STYLET_LANES void averaged_stiffness(const CellKernel& cells, const Product& p, double* pressure) {
  averaged<false>(cells, p, pressure);
}
STYLET_LANES void averaged_both(const CellKernel& cells, const Product& p, double* pressure) {
  averaged<true>(cells, p, pressure);
}

void pass(const CellKernel& cells, const Product& p, std::vector<double>& pressure) {
  if (!cells.averaged()) {
    p.mz != nullptr ? plain_both(cells, p) : plain_stiffness(cells, p);
    return;
  }
  pressure.resize(cells.stiffnesses().size());
  p.mz != nullptr ? averaged_both(cells, p, pressure.data())
                  : averaged_stiffness(cells, p, pressure.data());
}

}  // namespace

CellOperator::CellOperator(const Mesh& mesh, const TissueOperator& tissue) : tissue_(tissue) {
  make(mesh);
}

void CellOperator::make(const Mesh& mesh) {
  if (tissue_.dim() == 3) return;
  cells_ = CellKernel(mesh, tissue_);
  if (size_of(tissue_.comm()) == 1) return;
  for (OwnedVec& vec : ghosted_) vec = make_ghosted();
  for (auto& values : force_) values.resize(2 * cells_.nodes().n_all());
}

OwnedVec CellOperator::make_ghosted() const {
  const std::vector<int>& ghosts = cells_.nodes().ghosts();
  OwnedVec vec;
  check(VecCreateGhostBlock(tissue_.comm(), tissue_.dim(), tissue_.end_dof() - tissue_.first_dof(),
                            tissue_.n_dofs(), static_cast<PetscInt>(ghosts.size()), ghosts.data(),
                            vec.put()));
  return vec;
}

bool CellOperator::update(const Mesh& mesh, std::span<const int> cells) {
  if (tissue_.dim() == 3) return false;
  int lacks = cells_.update(mesh, tissue_, cells) ? 0 : 1;
  if (size_of(tissue_.comm()) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, &lacks, 1, MPI_INT, MPI_MAX, tissue_.comm());
  }
  if (lacks != 0) make(mesh);
  return lacks != 0;
}

void CellOperator::stiffness(Vec x, Vec y) {
  multiply(x, nullptr, y, nullptr);
}

void CellOperator::stiffness_and_mass(Vec x, Vec z, Vec kx, Vec mz) {
  if (tissue_.lumped_mass() == nullptr) {
    multiply(x, z, kx, mz);
    return;
  }
  multiply(x, nullptr, kx, nullptr);
  check(VecPointwiseMult(mz, tissue_.lumped_mass(), z));
}

void CellOperator::multiply(Vec x, Vec z, Vec kx, Vec mz) {
  static const LogEvent event("StyletProduct");
  const LogScope scope(event);
  const bool both = z != nullptr;
  if (tissue_.dim() == 3) {
    tissue_.apply_stiffness(x, kx);
    if (both) check(MatMult(tissue_.mass(), z, mz));
    return;
  }
  if (size_of(tissue_.comm()) == 1) {
    const Values from(x);
    const Values with(both ? z : x);
    Entries to(kx);
    if (!both) {
      pass(cells_, {from.data(), nullptr, to.data(), nullptr}, pressure_);
      return;
    }
    Entries mass(mz);
    pass(cells_, {from.data(), with.data(), to.data(), mass.data()}, pressure_);
    return;
  }
  const Vec in[2] = {x, z};
  const Vec out[2] = {kx, mz};
  const std::size_t n = both ? 2 : 1;
  for (std::size_t i = 0; i < n; ++i) {
    check(VecCopy(in[i], ghosted_[i].get()));
    check(VecGhostUpdateBegin(ghosted_[i].get(), INSERT_VALUES, SCATTER_FORWARD));
  }
  for (std::size_t i = 0; i < n; ++i) {
    check(VecGhostUpdateEnd(ghosted_[i].get(), INSERT_VALUES, SCATTER_FORWARD));
  }
  {
    const Values from(ghosted_[0].get());
    const Values with(ghosted_[1].get());
    pass(cells_, {from.data(), with.data(), force_[0].data(), both ? force_[1].data() : nullptr},
         pressure_);
  }
  for (std::size_t i = 0; i < n; ++i) {
    Entries to(out[i]);
    std::copy_n(force_[i].data(), 2 * cells_.nodes().n_owned(), to.data());
  }
}

}  // namespace stylet
