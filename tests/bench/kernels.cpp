// What a step is made of, on the reference scene's mesh refined 0 to 5 times (1226 to 1,255,424
// triangles), on one rank. "triangles" is a counter of each row.
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/explicit_step.hpp"
#include "stylet/fem/cell_operator.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/model.hpp"
#include "stylet/solvers/near_field.hpp"

#include "support/scenes.hpp"

#include <benchmark/benchmark.h>
#include <map>

namespace stylet {
namespace {

struct Tissue {
  explicit Tissue(const Scene& from)
      : scene(from),
        numbered(make_mesh(MPI_COMM_WORLD, scene)),
        tissue(make_tissue(MPI_COMM_WORLD, scene, numbered)) {}
  Scene scene;
  NumberedMesh numbered;
  std::unique_ptr<TissueOperator> tissue;
};

Tissue make(benchmark::State& state, const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> all{"mesh.refine=" + std::to_string(state.range(0)),
                               "tissue.damping={mass_factor: 200 1/s}", "time.method=explicit"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  Tissue tissue(reference_scene(all));
  state.counters["triangles"] = tissue.numbered.mesh.n_cells();
  return tissue;
}

OwnedVec ones(const TissueOperator& tissue) {
  OwnedVec vec = tissue.make_vector();
  check(VecSet(vec.get(), 1));
  return vec;
}

// The memory's share: a = b + 3 c, 24 bytes an entry.
void triad(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(1) << 24;
  std::vector<double> a(n);
  const std::vector<double> b(n, 1);
  const std::vector<double> c(n, 2);
  for (auto _ : state) {
    for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 3 * c[i];
    benchmark::DoNotOptimize(a.data());
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(24 * n) * state.iterations());
}

// K in blocks of two, row by row: MatConvert does not preallocate and takes minutes on 1e6 triangles.
OwnedMat blocks_of(Mat k) {
  PetscInt n = 0;
  check(MatGetSize(k, &n, nullptr));
  std::vector<PetscInt> width(static_cast<std::size_t>(n / 2));
  const auto row_of = [&](PetscInt row, auto&& use) {
    PetscInt m = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(k, row, &m, &columns, &values));
    use(m, columns, values);
    check(MatRestoreRow(k, row, &m, &columns, &values));
  };
  for (PetscInt node = 0; node < n / 2; ++node) {
    row_of(2 * node, [&](PetscInt m, const PetscInt*, const PetscScalar*) {
      width[static_cast<std::size_t>(node)] = m / 2;
    });
  }
  OwnedMat blocks;
  check(MatCreateSeqBAIJ(PETSC_COMM_SELF, 2, n, n, 0, width.data(), blocks.put()));
  std::vector<PetscInt> columns;
  std::vector<PetscScalar> values;
  for (PetscInt node = 0; node < n / 2; ++node) {
    columns.clear();
    values.clear();
    for (PetscInt row = 2 * node; row < 2 * node + 2; ++row) {
      row_of(row, [&](PetscInt m, const PetscInt* at, const PetscScalar* entries) {
        for (PetscInt j = 0; row == 2 * node && j < m; j += 2) columns.push_back(at[j] / 2);
        values.insert(values.end(), entries, entries + m);
      });
    }
    check(MatSetValuesBlocked(blocks.get(), 1, &node, static_cast<PetscInt>(columns.size()),
                              columns.data(), values.data(), INSERT_VALUES));
  }
  check(MatAssemblyBegin(blocks.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(blocks.get(), MAT_FINAL_ASSEMBLY));
  return blocks;
}

void stiffness(benchmark::State& state, bool in_blocks, const std::vector<std::string>& overrides) {
  const Tissue on = make(state, overrides);
  OwnedMat blocks;
  if (in_blocks) blocks = blocks_of(on.tissue->stiffness());
  Mat matrix = in_blocks ? blocks.get() : on.tissue->stiffness();
  const OwnedVec x = ones(*on.tissue);
  OwnedVec y = on.tissue->make_vector();
  for (auto _ : state) check(MatMult(matrix, x.get(), y.get()));
}

// The same cell by cell, as implicit steps need it, and with M v beside it.
void cells(benchmark::State& state, bool with_mass, const std::vector<std::string>& overrides) {
  std::vector<std::string> all{"time.method=implicit"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  const Tissue on = make(state, all);
  CellOperator operator_(on.numbered.mesh, *on.tissue);
  const OwnedVec x = ones(*on.tissue);
  OwnedVec y = on.tissue->make_vector();
  OwnedVec z = on.tissue->make_vector();
  for (auto _ : state) {
    if (with_mass) {
      operator_.stiffness_and_mass(x.get(), x.get(), y.get(), z.get());
    } else {
      operator_.stiffness(x.get(), y.get());
    }
  }
}

// K u with the rest of the step.
void explicit_step(benchmark::State& state, const std::vector<std::string>& overrides) {
  const Tissue on = make(state, overrides);
  const CellKernel cells(on.numbered.mesh, *on.tissue);
  std::vector<double> pressure;
  const auto n = static_cast<std::size_t>(on.tissue->n_dofs());
  std::vector<double> field[6];
  for (auto& values : field) values.assign(n, 1e-3);
  std::vector<double> mass;
  std::vector<double> inverse_root;
  const Values masses(on.tissue->lumped_mass());
  for (int dof = 0; dof < on.tissue->n_dofs(); dof += 2) {
    mass.push_back(masses[dof]);
    inverse_root.push_back(1 / std::sqrt(masses[dof]));
  }
  const ExplicitArrays x{n / 2,           field[0].data(), field[1].data(), field[2].data(),
                         field[3].data(), field[4].data(), field[5].data(), field[3].data(),
                         field[5].data(), nullptr,         mass.data(),     inverse_root.data()};
  for (auto _ : state) {
    StepSums sums;
    step(x, {1e-9, 200, 0}, cells, {}, pressure, sums);
    benchmark::DoNotOptimize(sums);
  }
}

// A node near the axis moves to and fro: mesh, K, M and the stable step follow.
void edit(benchmark::State& state) {
  Tissue on = make(state);
  Mesh& mesh = on.numbered.mesh;
  ExplicitNewmark integrator(*on.tissue, mesh, on.scene.time);
  int node = -1;
  for (int i = 0; i < mesh.n_nodes() && node < 0; ++i) {
    const ReferencePoint p = mesh.point(i);
    if (std::abs(p.x - 0.05) < 2e-3 && std::abs(p.y - 0.032) < 2e-3 && !mesh.is_locked(i)) node = i;
  }
  const ReferencePoint home = mesh.point(node);
  const double size = std::sqrt(mesh.cell_measure(mesh.cells_around(node).front()));
  const auto cells = mesh.cells_around(node);
  const std::vector<int> touched(cells.begin(), cells.end());
  bool away = false;
  for (auto _ : state) {
    away = !away;
    mesh.move_node(node, {home.x + (away ? 0.1 * size : 0), home.y});
    on.tissue->update(mesh, touched);
    integrator.touched(mesh, touched);
  }
}

struct Factored {
  explicit Factored(const Tissue& on) : operator_(), factor(MPI_COMM_WORLD, on.tissue->n_dofs()) {
    std::vector<PetscInt> left;
    for (const int node : on.numbered.mesh.nodes_of("left")) {
      left.push_back(2 * node);
      left.push_back(2 * node + 1);
    }
    operator_.take(on.tissue->stiffness(), left);
    factor.factor(operator_.matrix());
  }
  Eliminated operator_;
  Cholesky factor;
};

void factor(benchmark::State& state) {
  const Tissue on = make(state);
  for (auto _ : state) Factored a(on);
}

// Dofs of the nodes about the needle's axis.
std::vector<int> dofs_of_path(const Mesh& mesh) {
  const double size = std::sqrt(mesh.cell_measure(0));
  std::vector<int> nodes;
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    const ReferencePoint p = mesh.point(i);
    if (p.x > 0.035 && std::abs(p.y - 0.032) < 1.5 * size) nodes.push_back(i);
  }
  return dofs_of(nodes);
}

// Before and after the trials of an implicit step, with all of the path near.
void solve(benchmark::State& state) {
  const Tissue on = make(state);
  Factored a(on);
  const auto near = dofs_of_path(on.numbered.mesh);
  const std::vector<double> forces(near.size(), 1.0);
  const OwnedVec b = ones(*on.tissue);
  OwnedVec x = on.tissue->make_vector();
  for (auto _ : state) {
    a.factor.load(b.get());
    benchmark::DoNotOptimize(a.factor.loaded(near));
    a.factor.respond(near, forces, true, x.get());
  }
  state.counters["near"] = static_cast<double>(near.size());
}

void count_bytes(benchmark::State& state, double bytes) {
  state.counters["GB/s"] =
      benchmark::Counter(1e-9 * bytes, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["MB"] = 1e-6 * bytes;
}

// The two triangular solves of a whole step apart.
void forward(benchmark::State& state) {
  const Tissue on = make(state);
  Factored a(on);
  const OwnedVec b = ones(*on.tissue);
  for (auto _ : state) a.factor.load(b.get());
  count_bytes(state, a.factor.bytes());
}
void backward(benchmark::State& state) {
  const Tissue on = make(state);
  Factored a(on);
  const OwnedVec b = ones(*on.tissue);
  OwnedVec x = on.tissue->make_vector();
  a.factor.load(b.get());
  for (auto _ : state) a.factor.respond({}, {}, true, x.get());
  count_bytes(state, a.factor.bytes());
}

// Ten of them at all of the path.
void columns(benchmark::State& state) {
  const Tissue on = make(state);
  Factored a(on);
  const auto near = dofs_of_path(on.numbered.mesh);
  const auto some = std::span(near).first(10);
  for (auto _ : state) benchmark::DoNotOptimize(a.factor.inverse_entries(near, some));
  state.counters["near"] = static_cast<double>(near.size());
}

const std::vector<std::string> plain;
const std::vector<std::string> averaged{"tissue.formulation=p1_averaged"};

void register_all() {
  using benchmark::RegisterBenchmark;
  const auto sizes = [](auto* b, std::initializer_list<int> refine) {
    for (const int level : refine) b->Arg(level);
    b->Unit(benchmark::kMicrosecond);
  };
  sizes(RegisterBenchmark("triad", triad), {});
  sizes(RegisterBenchmark("K_u_aij", stiffness, false, plain), {0, 2, 3, 5});
  sizes(RegisterBenchmark("K_u_baij", stiffness, true, plain), {0, 2, 3, 5});
  sizes(RegisterBenchmark("K_u_cells", cells, false, plain), {0, 2, 3, 5});
  sizes(RegisterBenchmark("K_u_and_M_v_cells", cells, true, plain), {0, 2, 3, 5});
  sizes(RegisterBenchmark("explicit_step", explicit_step, plain), {0, 2, 3, 5});
  sizes(RegisterBenchmark("K_u_aij_averaged", stiffness, false, averaged), {0, 2, 3, 5});
  sizes(RegisterBenchmark("K_u_baij_averaged", stiffness, true, averaged), {0, 2, 3, 5});
  sizes(RegisterBenchmark("K_u_cells_averaged", cells, false, averaged), {0, 2, 3, 5});
  sizes(RegisterBenchmark("explicit_step_averaged", explicit_step, averaged), {0, 2, 3, 5});
  sizes(RegisterBenchmark("edit", edit), {0, 2, 3, 5});
  sizes(RegisterBenchmark("factor", factor), {0, 2, 3});
  sizes(RegisterBenchmark("solve", solve), {0, 2, 3, 5});
  sizes(RegisterBenchmark("forward", forward), {0, 2, 3, 4, 5});
  sizes(RegisterBenchmark("backward", backward), {0, 2, 3, 4, 5});
  sizes(RegisterBenchmark("columns", columns), {0, 2, 3, 5});
}

}  // namespace
}  // namespace stylet

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const stylet::Session session(1, argv);
  stylet::register_all();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
