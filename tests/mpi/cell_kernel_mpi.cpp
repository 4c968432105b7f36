// Triangles of a rank and its ghosts push owned nodes as the operator's rows do, also after flips that
// bring new ghosts.
#include "stylet/dynamics/explicit_step.hpp"
#include "stylet/dynamics/state.hpp"
#include "stylet/fem/cell_operator.hpp"
#include "stylet/mesh/numbering.hpp"
#include "stylet/mesh/rectangle.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"

#include "support/edits.hpp"
#include <gtest/gtest.h>

#include <optional>
#include <random>

namespace stylet {
namespace {

const MPI_Comm world = MPI_COMM_WORLD;

class RankKernel : public testing::TestWithParam<Formulation> {};
INSTANTIATE_TEST_SUITE_P(Formulations,
                         RankKernel,
                         testing::Values(Formulation::p1, Formulation::p1_averaged));

void expect_forces(const Mesh& mesh, const TissueOperator& tissue, const CellKernel& cells) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<double> field;
  for (int dof = 0; dof < 2 * mesh.n_nodes(); ++dof) field.push_back(any(random));
  OwnedVec u = tissue.make_vector();
  for (int dof = 0; dof < tissue.n_dofs(); ++dof) {
    set_owned(u.get(), dof, field[static_cast<std::size_t>(dof)]);
  }
  OwnedVec f = tissue.make_vector();
  check(MatMult(tissue.stiffness(), u.get(), f.get()));
  const auto expected = gather_all(f.get());

  std::vector<double> stretched(2 * cells.nodes().n_all());
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const int local = cells.nodes().of(node);
    for (std::size_t i = 0; local >= 0 && i < 2; ++i) {
      stretched[2 * static_cast<std::size_t>(local) + i] =
          field[2 * static_cast<std::size_t>(node) + i];
    }
  }
  const std::size_t n = cells.nodes().n_owned();
  std::vector<double> v(2 * n, 0.0);
  std::vector<double> a(2 * n);
  std::vector<double> force(stretched.size(), 0.0);
  const std::vector<double> ones(n, 1.0);
  const ExplicitArrays x{n,           nullptr,    nullptr,          nullptr,      nullptr,
                         v.data(),    a.data(),   stretched.data(), force.data(), nullptr,
                         ones.data(), ones.data()};
  std::vector<double> pressure;
  StepSums sums;
  accelerate(x, {0, 0, 0}, cells, pressure, sums);
  double size = 0;
  double worst = 0;
  for (std::size_t i = 0; i < 2 * n; ++i) {
    const double by_rows = expected[static_cast<std::size_t>(tissue.first_dof()) + i];
    size = std::max(size, std::abs(by_rows));
    worst = std::max(worst, std::abs(by_rows + a[i]));
  }
  EXPECT_LE(worst, 1e-12 * size);
}

// K x and M z of random fields against the assembled matrices.
void expect_products(const TissueOperator& tissue, CellOperator& cells) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> any(-1, 1);
  OwnedVec fields[2] = {tissue.make_vector(), tissue.make_vector()};
  for (int dof = 0; dof < tissue.n_dofs(); ++dof) {
    for (const OwnedVec& field : fields) set_owned(field.get(), dof, any(random));
  }
  OwnedVec got[2] = {tissue.make_vector(), tissue.make_vector()};
  OwnedVec expected[2] = {tissue.make_vector(), tissue.make_vector()};
  cells.stiffness_and_mass(fields[0].get(), fields[1].get(), got[0].get(), got[1].get());
  check(MatMult(tissue.stiffness(), fields[0].get(), expected[0].get()));
  tissue.apply_mass(fields[1].get(), expected[1].get());
  const auto expect_near = [](Vec a, Vec b) {
    PetscReal size = 0;
    PetscReal miss = 0;
    check(VecNorm(b, NORM_INFINITY, &size));
    check(VecAXPY(a, -1, b));
    check(VecNorm(a, NORM_INFINITY, &miss));
    EXPECT_LE(miss, 1e-12 * size);  // round-off of sums of a dozen terms, some of them cancelling
  };
  for (std::size_t i = 0; i < 2; ++i) expect_near(got[i].get(), expected[i].get());
  cells.stiffness(fields[1].get(), got[0].get());
  check(MatMult(tissue.stiffness(), fields[1].get(), expected[0].get()));
  expect_near(got[0].get(), expected[0].get());
}

/// Two materials, and the pieces that hold it.
struct Block {
  Block(MassKind mass, Formulation formulation) {
    RectangleMesh p;
    p.width = 0.08;
    p.height = 0.06;
    p.columns = 24;
    p.rows = 18;
    p.jitter = 0.2;
    p.inner_regions.push_back({"core", Ellipse{{0.045, 0.03}, 0.02, 0.015}});
    const MeshData data = make_rectangle(p);
    auto numbering = number_nodes(data, size_of(world));
    std::vector<int> old_cell;
    mesh.emplace(renumber(data, numbering, old_cell));
    TissueParameters parameters;
    parameters.plane = Plane::strain;
    parameters.mass = mass;
    parameters.formulation = formulation;
    parameters.regions = {{"tissue", {60e3, 0.45, 1000}}, {"core", {9e3, 0.49, 1000}}};
    tissue.emplace(world, *mesh, std::move(numbering.first_node), parameters,
                   [](int) { return true; });
  }
  std::optional<Mesh> mesh;
  std::optional<TissueOperator> tissue;
};

TEST_P(RankKernel, PushesAsTheRowsDoAfterEdits) {
  Block block(MassKind::lumped, GetParam());
  Mesh& mesh = *block.mesh;
  TissueOperator& tissue = *block.tissue;
  CellKernel cells(mesh, tissue);
  expect_forces(mesh, tissue, cells);
  std::mt19937 random(3);
  int renewed = 0;
  for (int round = 0; round < 6; ++round) {
    auto touched = move_nodes(mesh, random);
    const auto flipped = flip_edges(mesh);
    touched.insert(touched.end(), flipped.begin(), flipped.end());
    tissue.update(mesh, touched);
    if (!cells.update(mesh, tissue, touched)) {
      cells = CellKernel(mesh, tissue);
      ++renewed;
    }
    expect_forces(mesh, tissue, cells);
  }
  MPI_Allreduce(MPI_IN_PLACE, &renewed, 1, MPI_INT, MPI_SUM, world);
  EXPECT_EQ(renewed > 0, size_of(world) > 1);
}

TEST_P(RankKernel, MultipliesAsTheMatricesDoAfterEdits) {
  for (const MassKind mass : {MassKind::consistent, MassKind::lumped}) {
    Block block(mass, GetParam());
    CellOperator cells(*block.mesh, *block.tissue);
    expect_products(*block.tissue, cells);
    std::mt19937 random(3);
    for (int round = 0; round < 3; ++round) {
      auto touched = move_nodes(*block.mesh, random);
      const auto flipped = flip_edges(*block.mesh);
      touched.insert(touched.end(), flipped.begin(), flipped.end());
      block.tissue->update(*block.mesh, touched);
      cells.update(*block.mesh, touched);
      expect_products(*block.tissue, cells);
    }
  }
}

}  // namespace
}  // namespace stylet
