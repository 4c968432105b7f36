// Triangles of a rank and its ghosts push owned nodes as the operator's rows do, also after flips that
// bring new ghosts.
#include "stylet/dynamics/explicit_step.hpp"
#include "stylet/dynamics/state.hpp"
#include "stylet/mesh/numbering.hpp"
#include "stylet/mesh/rectangle.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"

#include "support/edits.hpp"
#include <gtest/gtest.h>

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

TEST_P(RankKernel, PushesAsTheRowsDoAfterEdits) {
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
  Mesh mesh(renumber(data, numbering, old_cell));
  TissueParameters parameters;
  parameters.plane = Plane::strain;
  parameters.mass = MassKind::lumped;
  parameters.formulation = GetParam();
  parameters.regions = {{"tissue", {60e3, 0.45, 1000}}, {"core", {9e3, 0.49, 1000}}};
  TissueOperator tissue(world, mesh, std::move(numbering.first_node), parameters,
                        [](int) { return true; });
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
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &renewed, 1, MPI_INT, MPI_SUM, world));
  EXPECT_EQ(renewed > 0, size_of(world) > 1);
}

}  // namespace
}  // namespace stylet
