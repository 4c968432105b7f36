// Tissue condensed to the dofs near the needle: whole scenes with every solver of the whole tissue below
// the same near field, which options ask for: the same energies, forces and fields at any time, on any
// number of ranks.
#include "stylet/petsc/check.hpp"
#include "stylet/solvers/whole_solver.hpp"

#include "support/needles_in_space.hpp"
#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stylet {
namespace {

using testing::AllOf;
using testing::Ge;
using testing::Le;

const std::string pierced = R"(
mesh:
  rectangle:
    size: [8 cm, 6 cm]
    columns: 16
    rows: 12
    jitter: 0.1
    inner_regions: [{name: core, polygon: [[2 cm, 1.5 cm], [4 cm, 1.5 cm], [4 cm, 4.5 cm], [2 cm, 4.5 cm]]}]
tissue:
  plane: stress
  regions:
    tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
    core: {youngs_modulus: 120 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
  damping: {stiffness_factor: 0.05 s, mass_factor: 2 1/s}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 3.1 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion: [insert: {speed: 2 cm/s, depth: 4 cm}, implant: {}, retract: {speed: 2 cm/s}, settle: {duration: 0.1 s}]
targets: {seed: [4 cm, 3.1 cm]}
time: {method: quasi_static, step: 50 ms}
)";

// Largest entries, so that differences have a scale.
double size_of_values(const std::vector<double>& values) {
  double size = 0;
  for (const double value : values) size = std::max(size, std::abs(value));
  return size;
}

struct Way {
  std::vector<double> numbers;  // of every step: forces (N) and energies (J)
  std::vector<std::vector<double>> fields;
  double placement_error = 0;
};

// Looks at the fields in every `interval`th step only: the near field leaves them out in between.
Way way_of(const std::vector<std::string>& overrides,
           const std::string& options,
           int interval,
           const std::string& text = pierced) {
  check(PetscOptionsInsertString(nullptr, options.c_str()));
  Way way;
  Simulation simulation(MPI_COMM_WORLD, scene_of(text, overrides), true);
  int n = 0;
  run_to_end(simulation, [&](const StepRecord& record) {
    const Energies& e = simulation.energies();
    way.numbers.insert(way.numbers.end(), {record.needle.forces.tip, record.needle.forces.friction,
                                           e.strain, e.kinetic, e.external, e.edits});
    if (++n % interval != 0) return;
    way.fields.push_back(gather_all(simulation.state().u.get()));
    way.fields.push_back(gather_all(simulation.state().v.get()));
  });
  way.placement_error = simulation.placement_errors().at(0);
  for (const char* option : {"-ksp_type", "-pc_type", "-pc_factor_mat_solver_type"}) {
    check(PetscOptionsClearValue(nullptr, option));
  }
  return way;
}

void expect_same(const Way& near, const Way& whole) {
  // Columns of the inverse are good to 1e-12 of the residual, times the condition of this operator.
  constexpr double tolerance = 1e-9;
  EXPECT_NEAR(near.placement_error, whole.placement_error, tolerance * whole.placement_error);
  ASSERT_EQ(near.numbers.size(), whole.numbers.size());
  for (std::size_t k = 0; k < 6; ++k) {
    double scale = 0;
    for (std::size_t i = k; i < whole.numbers.size(); i += 6) {
      scale = std::max(scale, std::abs(whole.numbers[i]));
    }
    for (std::size_t i = k; i < whole.numbers.size(); i += 6) {
      EXPECT_NEAR(near.numbers[i], whole.numbers[i], tolerance * scale) << "number " << k;
    }
  }
  ASSERT_EQ(near.fields.size(), whole.fields.size());
  ASSERT_GT(near.fields.size(), 4U);
  for (std::size_t f = 0; f < near.fields.size(); ++f) {
    const double scale = std::max(size_of_values(whole.fields[f]), 1e-6);
    double worst = 0;
    for (std::size_t i = 0; i < near.fields[f].size(); ++i) {
      worst = std::max(worst, std::abs(near.fields[f][i] - whole.fields[f][i]));
    }
    EXPECT_LT(worst, tolerance * scale) << "field " << f;
  }
}

class NearFieldScene : public testing::TestWithParam<std::vector<std::string>> {};

TEST_P(NearFieldScene, AnswersWithConjugateGradientsBelow) {
  expect_same(way_of(GetParam(), "", 7), way_of(GetParam(), "-pc_type jacobi", 7));
}

class SolverBelow : public testing::TestWithParam<const char*> {};

TEST_P(SolverBelow, AnswersTheSame) {
  for (const char* method : {"quasi_static", "implicit"}) {
    const std::vector<std::string> overrides{std::string("time.method=") + method,
                                             "needles.0.motion.0.insert.depth=1 cm"};
    expect_same(way_of(overrides, "", 7), way_of(overrides, GetParam(), 7));
  }
}

// Rows of a track, whose columns of the inverse are kept.
TEST_P(SolverBelow, AnswersTheSameInSpace) {
  for (const char* method : {"quasi_static", "implicit"}) {
    const std::vector<std::string> overrides{
        std::string("time.method=") + method,
        "needles.0.motion=[insert: {speed: 20 cm/s, depth: 1 cm}, implant: {}, retract: {speed: 30 "
        "cm/s}]",
        "needles.1.motion=[insert: {speed: 20 cm/s, depth: 7 mm}, retract: {speed: 30 cm/s}]"};
    expect_same(way_of(overrides, "", 3, needles_in_space),
                way_of(overrides, GetParam(), 3, needles_in_space));
  }
}

INSTANTIATE_TEST_SUITE_P(Options,
                         SolverBelow,
                         testing::Values("-pc_factor_mat_solver_type mumps",
                                         "-pc_type gamg -ksp_type cg",
                                         "-pc_type hypre",
                                         "-ksp_type cg"));

// By what it takes of the memory: numbers of dofs around each limit.
TEST(SolverChoice, IsByTheRoomThatAFactorTakes) {
  constexpr double machine = 16e9;  // half of it has room for 3.3e6 dofs at 2400 bytes
  const auto solver_for = [](double n_dofs, int ranks, int ranks_of_machine, double memory) {
    const double factor = factor_bytes(2, n_dofs, 14);
    return stylet::solver_for(factor, factor, ranks, ranks_of_machine, memory);
  };
  EXPECT_EQ(solver_for(3'300'000, 1, 1, machine), SolverKind::factor_everywhere);
  EXPECT_EQ(solver_for(3'400'000, 1, 1, machine), SolverKind::multigrid);
  EXPECT_EQ(solver_for(1'600'000, 2, 2, machine), SolverKind::factor_everywhere);
  EXPECT_EQ(solver_for(1'700'000, 2, 2, machine), SolverKind::factor_distributed);
  EXPECT_EQ(solver_for(2'200'000, 2, 2, machine), SolverKind::multigrid);
  // Ranks on other machines take their share of a distributed one.
  EXPECT_EQ(solver_for(3'000'000, 8, 2, machine), SolverKind::factor_distributed);
  EXPECT_EQ(solver_for(8'000'000, 8, 2, machine), SolverKind::factor_distributed);
  EXPECT_EQ(solver_for(9'000'000, 8, 2, machine), SolverKind::multigrid);
  // In space a dof takes the more the larger the mesh is.
  EXPECT_GT(factor_bytes(3, 1e5, 42), 15 * factor_bytes(3, 1e4, 42));
  EXPECT_GT(factor_bytes(3, 1e5, 180), 1.5 * factor_bytes(3, 1e5, 42));
  // As measured: p1 and p1_averaged on tetrahedra of Gmsh, p1 of a box.
  EXPECT_THAT(factor_bytes(3, 61113, 42) / 330e6, AllOf(Ge(1), Le(1.3)));
  EXPECT_THAT(factor_bytes(3, 61113, 180) / 588e6, AllOf(Ge(0.95), Le(1.3)));
  EXPECT_THAT(assembled_factor_bytes(3, 27075, 258) / 391e6, AllOf(Ge(1), Le(1.3)));
  EXPECT_EQ(stylet::solver_for(9e9, 20e9, 2, 2, machine), SolverKind::multigrid);
  EXPECT_EQ(stylet::solver_for(5e9, 5e9, 2, 2, machine), SolverKind::factor_distributed);
  EXPECT_THAT(factor_bytes(3, 582624, 42) / 6.53e9, AllOf(Ge(1), Le(1.3)));
}

// The distance from the needle at which loads and prescribed displacements act makes no difference.
INSTANTIATE_TEST_SUITE_P(
    Scenes,
    NearFieldScene,
    testing::Values(
        std::vector<std::string>{},
        std::vector<std::string>{"tissue.formulation=p1_averaged"},
        std::vector<std::string>{"loads.traction=[{curve: right, force: [6 N/m, 0 N/m]}]"},
        std::vector<std::string>{
            "supports={left: fixed, bottom: fixed}",
            "prescribed=[{curve: top, displacement: [0 mm, -1 mm], start: 0.2 s, ramp: 0.5 s}]"},
        std::vector<std::string>{"time.method=implicit", "needles.0.cutting.tip_length=0 mm"},
        std::vector<std::string>{
            "time.method=implicit", "tissue.mass=lumped", "supports={left: fixed, bottom: fixed}",
            "prescribed=[{curve: top, displacement: [0 mm, -1 mm], start: 0.2 s, ramp: 0.5 s}]"},
        std::vector<std::string>{"time.method=implicit", "time.scheme=generalised_alpha",
                                 "time.rho_infinity=0.8", "tissue.formulation=p1_averaged"}));

}  // namespace
}  // namespace stylet
