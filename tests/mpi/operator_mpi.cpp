// The tissue operator has the same bits on any number of ranks, and an edited one those of a fresh
// one. Entries are compared one by one with ==; where one pattern lacks an entry the other holds an
// exact zero.
#include "stylet/dynamics/state.hpp"
#include "stylet/fem/tissue_operator.hpp"
#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/numbering.hpp"
#include "stylet/mesh/rectangle.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/loader.hpp"
#include "stylet/simulation/simulation.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>
#include <vector>

namespace stylet {

namespace {

const MPI_Comm world = MPI_COMM_WORLD;

/// A mesh in the numbers of this many ranks, two regions.
struct Numbered {
  Mesh mesh;
  std::vector<int> first_node;
};

Numbered numbered_mesh() {
  RectangleMesh p;
  p.width = 0.08;
  p.height = 0.06;
  p.columns = 14;
  p.rows = 10;
  p.jitter = 0.2;
  p.inner_regions.push_back({"core", Ellipse{{0.035, 0.03}, 0.035, 0.026}});
  const MeshData data = make_rectangle(p);
  auto numbering = number_nodes(data, size_of(world));
  std::vector<int> old_cell;
  Mesh mesh(renumber(data, numbering, old_cell));
  return {std::move(mesh), std::move(numbering.first_node)};
}

using Kind = std::pair<MassKind, Formulation>;

TissueParameters parameters(Kind kind, double core_modulus) {
  TissueParameters p;
  p.mass = kind.first;
  p.formulation = kind.second;
  p.regions = {{"tissue", {60e3, 0.45, 1000}}, {"core", {core_modulus, 0.45, 1000}}};
  p.damping = RayleighDamping{3, 0.05};
  return p;
}

using Row = std::map<int, double>;

/// Owned rows by row and column, without zeros.
std::map<int, Row> rows_of(Mat matrix) {
  std::map<int, Row> rows;
  if (matrix == nullptr) return rows;
  PetscInt begin = 0;
  PetscInt end = 0;
  check(MatGetOwnershipRange(matrix, &begin, &end));
  for (PetscInt row = begin; row < end; ++row) {
    PetscInt n = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(matrix, row, &n, &columns, &values));
    for (PetscInt i = 0; i < n; ++i) {
      if (values[i] != 0) rows[row][columns[i]] = values[i];
    }
    check(MatRestoreRow(matrix, row, &n, &columns, &values));
  }
  return rows;
}

void expect_same_rows(const char* what, Mat mine, Mat other) {
  const auto expected = rows_of(other);
  int differences = 0;
  for (const auto& [row, values] : rows_of(mine)) {
    const auto found = expected.find(row);
    if (found == expected.end() || found->second != values) ++differences;
  }
  EXPECT_EQ(differences, 0) << what << ": rows that differ on rank " << rank_of(world);
}

void expect_same(const TissueOperator& mine, const TissueOperator& other) {
  expect_same_rows("K", mine.stiffness(), other.stiffness());
  expect_same_rows("M", mine.mass(), other.mass());
  if (mine.tangent_matrix() != nullptr && other.tangent_matrix() != nullptr) {
    expect_same_rows("tangent", mine.tangent_matrix(), other.tangent_matrix());
  }
  if (mine.lumped_mass() == nullptr) return;
  const auto all = gather_all(mine.lumped_mass());
  EXPECT_EQ(all, gather_all(other.lumped_mass())) << "row-sum mass";
}

class Operators : public testing::TestWithParam<Kind> {};

TEST_P(Operators, SameBitsAsOnOneRank) {
  const auto [mesh, first_node] = numbered_mesh();
  const auto p = parameters(GetParam(), 600e3);
  TissueOperator together(world, mesh, first_node, p);
  TissueOperator alone(MPI_COMM_SELF, mesh, {0, mesh.n_nodes()}, p);
  for (auto* tissue : {&together, &alone}) tissue->make_tangent(tissue->tangent(200, 4e4));
  expect_same(together, alone);
}

/// Random edits that leave valid triangles; the cells they touch.
class Editor {
 public:
  explicit Editor(Mesh& mesh) : mesh_(mesh) {}

  std::vector<int> edit() { return random_() % 3 == 0 ? flip() : move(); }
  [[nodiscard]] int n_flips() const { return n_flips_; }

 private:
  std::vector<int> move() {
    for (;;) {
      const int node = static_cast<int>(random_() % static_cast<unsigned>(mesh_.n_nodes()));
      if (mesh_.is_locked(node)) continue;
      const ReferencePoint from = mesh_.point(node);
      mesh_.move_node(node, from + Vector2{step(), step()});
      const auto around = mesh_.cells_around(node);
      if (mesh_.worst_quality(around) > 0.1) return {around.begin(), around.end()};
      mesh_.move_node(node, from);
    }
  }
  std::vector<int> flip() {
    for (;;) {
      const int c = static_cast<int>(random_() % static_cast<unsigned>(mesh_.n_cells()));
      const int a = mesh_.cell(c)[0];
      const int b = mesh_.cell(c)[1];
      if (mesh_.is_locked_edge(a, b)) continue;
      // Looked at before it is done: a flip that is taken back leaves the cells in another order.
      const auto both = mesh_.cells_with(a, b);
      const auto near = mesh_.point(mesh_.opposite(c, a, b));
      const auto far = mesh_.point(mesh_.opposite(both[0] == c ? both[1] : both[0], a, b));
      const double worst =
          std::min(quality(near, mesh_.point(a), far), quality(near, far, mesh_.point(b)));
      if (worst < 0.1) continue;
      mesh_.flip_edge(a, b);
      ++n_flips_;
      return both;
    }
  }
  double step() { return 2e-3 * (static_cast<double>(random_()) / random_.max() - 0.5); }

  Mesh& mesh_;
  std::mt19937 random_{7};
  int n_flips_ = 0;
};

struct Edited {
  int rebuilds = 0;
  std::vector<int> touched;
};

/// Edits mesh and operator step by step, each edit on its own.
Edited edit(Mesh& mesh, TissueOperator& tissue, int n_edits) {
  Editor editor(mesh);
  Edited edited;
  for (int i = 0; i < n_edits; ++i) {
    const auto cells = editor.edit();
    edited.rebuilds += tissue.update(mesh, cells) ? 1 : 0;
    edited.touched.insert(edited.touched.end(), cells.begin(), cells.end());
  }
  EXPECT_GT(editor.n_flips(), n_edits / 10);
  return edited;
}

TEST_P(Operators, EditedEqualsFresh) {
  auto [mesh, first_node] = numbered_mesh();
  const auto p = parameters(GetParam(), 60e3);  // one material: nothing is mixed
  TissueOperator edited(world, mesh, first_node, p, [](int) { return true; });
  edited.make_tangent(edited.tangent(200, 4e4));
  edit(mesh, edited, 150);
  TissueOperator fresh(world, mesh, first_node, p);
  fresh.make_tangent(fresh.tangent(200, 4e4));
  expect_same(edited, fresh);
}

TEST_P(Operators, EditedEqualsFreshWhereThePatternHasNoRoom) {
  auto [mesh, first_node] = numbered_mesh();
  const auto p = parameters(GetParam(), 60e3);
  const auto nowhere = [](int) { return false; };
  TissueOperator edited(world, mesh, first_node, p, nowhere);
  edited.make_tangent(edited.tangent(200, 4e4));
  EXPECT_GT(edit(mesh, edited, 60).rebuilds, 0);
  TissueOperator fresh(world, mesh, first_node, p);
  fresh.make_tangent(fresh.tangent(200, 4e4));
  expect_same(edited, fresh);
}

TEST_P(Operators, MixedMaterialsDependOnTheMeshAlone) {
  // Two stiffnesses: an edited cell mixes what lies below it, however it came there.
  auto [mesh, first_node] = numbered_mesh();
  const auto p = parameters(GetParam(), 600e3);
  const auto everywhere = [](int) { return true; };
  TissueOperator step_by_step(world, mesh, first_node, p, everywhere);
  TissueOperator at_once(world, mesh, first_node, p, everywhere);
  for (auto* tissue : {&step_by_step, &at_once}) tissue->make_tangent(tissue->tangent(200, 4e4));
  const auto edited = edit(mesh, step_by_step, 150);
  at_once.update(mesh, edited.touched);
  expect_same(step_by_step, at_once);
}

INSTANTIATE_TEST_SUITE_P(Kinds,
                         Operators,
                         testing::Values(Kind{MassKind::consistent, Formulation::p1},
                                         Kind{MassKind::lumped, Formulation::p1},
                                         Kind{MassKind::consistent, Formulation::p1_averaged},
                                         Kind{MassKind::lumped, Formulation::p1_averaged}),
                         [](const auto& kind) {
                           const bool averaged = kind.param.second == Formulation::p1_averaged;
                           return std::string(kind.param.first == MassKind::lumped ? "lumped"
                                                                                   : "consistent") +
                                  (averaged ? "_averaged" : "");
                         });

TEST(NeedleEdits, OperatorAfterAnInsertionEqualsFresh) {
  const std::string text =
      R"(mesh: {rectangle: {size: [8 cm, 6 cm], columns: 14, rows: 10, jitter: 0.2}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 3.17 cm
    cutting: {cutting_force: 1.7 N}
    motion: [insert: {speed: 2 cm/s, depth: 3 cm}]
time: {step: 50 ms}
output: {history: false}
)";
  for (const std::string mass : {"consistent", "lumped"}) {
    Simulation simulation(world, load_scene("scene.yaml", text, {"tissue.mass=" + mass}), false);
    while (!simulation.done()) simulation.step();
    EXPECT_GT(simulation.counts().needle.hand_overs, 3);
    const auto& tissue = simulation.tissue();
    TissueOperator fresh(world, simulation.mesh(), tissue.first_node(), tissue.parameters());
    expect_same(tissue, fresh);
  }
}

}  // namespace

}  // namespace stylet
