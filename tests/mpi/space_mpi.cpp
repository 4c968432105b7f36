// Tissue in space on several ranks: the same rows, and the same runs as one rank alone computes beside.
#include "stylet/fem/tissue_operator.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/model.hpp"

#include "support/needles_in_space.hpp"
#include "support/scenes.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

const std::string scene = R"(
mesh:
  box:
    size: [8 cm, 6 cm, 4 cm]
    columns: 8
    rows: 6
    layers: 4
    jitter: 0.15
    inner_regions: [{name: gland, ellipsoid: {centre: [4 cm, 3 cm, 2 cm], size: [6 cm, 4.4 cm, 3.4 cm]}}]
tissue:
  regions:
    tissue: {youngs_modulus: 30 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}
    gland: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1100 kg/m^3}
supports: {left: fixed, bottom: roller}
loads:
  body: [{force: [0 N/m^3, -9.81 kN/m^3, 0 N/m^3]}]
  traction: [{surface: front, stress: [100 Pa, 0 Pa, -200 Pa]}]
prescribed: [{surface: right, displacement: [null, null, 1 mm], ramp: 20 ms}]
probes: {corner: [8 cm, 6 cm, 4 cm], inside: [3.3 cm, 2.9 cm, 1.7 cm]}
time: {method: implicit, step: 5 ms, duration: 40 ms}
)";

struct Outcome {
  std::vector<double> numbers;
};

Outcome outcome_of(MPI_Comm comm, const std::vector<std::string>& changes) {
  Simulation simulation(comm, scene_of(scene, changes), true);
  run_to_end(simulation);
  Outcome outcome;
  for (const auto& x : simulation.body().world(simulation.probes())) {
    outcome.numbers.insert(outcome.numbers.end(), {x.x, x.y, x.z});
  }
  const Vector3 force = simulation.body().curve_reaction(0);
  outcome.numbers.insert(outcome.numbers.end(), {force.x, force.y, force.z});
  const Energies& e = simulation.energies();
  outcome.numbers.insert(outcome.numbers.end(), {e.kinetic, e.strain, e.external});
  return outcome;
}

TEST(SpaceMpi, RunsAreTheSameOnAnyNumberOfRanks) {
  for (const std::string element : {"p1", "p1_averaged", "p2"}) {
    for (const std::string time :
         {"{method: quasi_static, step: 10 ms, duration: 40 ms}",
          "{method: implicit, step: 5 ms, duration: 40 ms}",
          "{method: implicit, scheme: generalised_alpha, step: 5 ms, duration: 40 ms}",
          "{method: explicit, step: 1 ms, duration: 10 ms}"}) {
      std::vector<std::string> changes{"time=" + time, "tissue.formulation=" + element};
      if (time.find("explicit") != std::string::npos) {
        changes.emplace_back("tissue.damping={mass_factor: 5 1/s}");
      } else if (time.find("implicit") != std::string::npos) {
        changes.emplace_back("tissue.damping={mass_factor: 5 1/s, stiffness_factor: 1 ms}");
      }
      const Outcome all = outcome_of(MPI_COMM_WORLD, changes);
      const Outcome alone = outcome_of(MPI_COMM_SELF, changes);
      for (std::size_t i = 0; i < all.numbers.size(); ++i) {
        EXPECT_NEAR(all.numbers[i], alone.numbers[i], 1e-8 * std::abs(alone.numbers[i]) + 1e-15)
            << time << " " << element << " " << i;
      }
    }
  }
}

TEST(SpaceMpi, NeedlesAreTheSameOnAnyNumberOfRanks) {
  for (const std::string time :
       {"{method: quasi_static, step: 5 ms}", "{method: implicit, step: 5 ms}",
        "{method: explicit, step: 5 ms}"}) {
    const Scene given = scene_of(needles_in_space, {"time=" + time});
    Simulation all(MPI_COMM_WORLD, given, true);
    Simulation alone(MPI_COMM_SELF, given, true);
    double furthest = 0;
    double strongest = 0;
    while (!alone.done()) {
      const StepRecord record = all.step();
      const StepRecord expected = alone.step();
      furthest =
          std::max(furthest, std::abs(all.needle()->path_length() - alone.needle()->path_length()));
      strongest = std::max(strongest,
                           std::abs(record.needle.forces.total() - expected.needle.forces.total()));
      ASSERT_EQ(record.needle.n_stick, expected.needle.n_stick) << record.t;
    }
    EXPECT_TRUE(all.done());
    EXPECT_LT(furthest, 1e-10) << time;
    EXPECT_LT(strongest, 1e-7) << time;
    ASSERT_EQ(all.seeds().size(), 1U);
    EXPECT_LT(distance(all.place_of(all.seeds()[0]).x, alone.place_of(alone.seeds()[0]).x), 1e-10);
    EXPECT_EQ(all.counts().needle.punctures, alone.counts().needle.punctures);
  }
}

// The patch test: uniform strain on tetrahedra of which no two are alike.
TEST(SpaceMpi, ALinearFieldIsExactOnAnyNumberOfRanks) {
  for (const std::string element : {"p1", "p1_averaged", "p2"}) {
    Simulation simulation(MPI_COMM_WORLD,
                          scene_of(R"(
mesh: {box: {size: [8 cm, 6 cm, 4 cm], columns: 8, rows: 6, layers: 4, jitter: 0.25}}
tissue:
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}}
supports: {left: roller, bottom: roller, back: roller}
loads: {traction: [{surface: right, stress: [600 Pa, 0 Pa, 0 Pa]}]}
probes: {a: [8 cm, 6 cm, 4 cm], b: [3.3 cm, 2.9 cm, 1.7 cm], c: [0.4 cm, 5.1 cm, 3.9 cm]}
time: {method: quasi_static}
)",
                                   {"tissue.formulation=" + element}),
                          false);
    run_to_end(simulation);
    const auto world = simulation.body().world(simulation.probes());
    for (std::size_t i = 0; i < world.size(); ++i) {
      const ReferencePlace x = simulation.probes()[i].x;
      EXPECT_NEAR(world[i].x - x.x, 0.01 * x.x, 1e-13);
      EXPECT_NEAR(world[i].y - x.y, -0.003 * x.y, 1e-13);
      EXPECT_NEAR(world[i].z - x.z, -0.003 * x.z, 1e-13);
    }
  }
}

// The owner computes its rows in the order of cells, so K is the same to the last bit.
TEST(SpaceMpi, RowsHaveTheSameBits) {
  for (const std::string element : {"p1_averaged", "p2"}) {
    const Scene given = scene_of(scene, {"tissue.formulation=" + element});
    const NumberedMesh numbered = make_mesh(MPI_COMM_WORLD, given);
    const auto here = make_tissue(MPI_COMM_WORLD, given, numbered);
    NumberedMesh alone = make_mesh(MPI_COMM_WORLD, given);
    alone.first_node = {0, alone.mesh.n_nodes()};
    const auto whole = make_tissue(MPI_COMM_SELF, given, alone);
    for (int row = here->first_dof(); row < here->end_dof(); ++row) {
      PetscInt n = 0;
      PetscInt m = 0;
      const PetscInt* columns = nullptr;
      const PetscScalar* values = nullptr;
      std::vector<double> mine;
      check(MatGetRow(here->stiffness(), row, &n, &columns, &values));
      mine.assign(values, values + n);
      check(MatRestoreRow(here->stiffness(), row, &n, &columns, &values));
      check(MatGetRow(whole->stiffness(), row, &m, &columns, &values));
      EXPECT_EQ(mine, std::vector<double>(values, values + m));
      check(MatRestoreRow(whole->stiffness(), row, &m, &columns, &values));
    }
  }
}

}  // namespace
}  // namespace stylet
