// Scenes in space through every time method, and what is refused in them.
#include "stylet/base/errors.hpp"
#include "stylet/petsc/gather.hpp"

#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Pulled at its right side with 1 % of strain, which linear tetrahedra hold exactly.
const std::string pulled = R"(
mesh: {box: {size: [8 cm, 6 cm, 4 cm], columns: 4, rows: 3, layers: 2, jitter: 0.2}}
tissue:
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}}
supports: {left: roller, bottom: roller, back: roller}
loads: {traction: [{surface: right, stress: [600 Pa, 0 Pa, 0 Pa]}]}
probes: {corner: [8 cm, 6 cm, 4 cm]}
time: {method: quasi_static}
)";

Vector3 corner_moved(const Simulation& simulation) {
  const auto world = simulation.body().world(simulation.probes())[0];
  return {world.x - 0.08, world.y - 0.06, world.z - 0.04};
}

void expect_pulled(const Simulation& simulation) {
  const Vector3 u = corner_moved(simulation);
  EXPECT_NEAR(u.x, 0.8e-3, 1e-12);
  EXPECT_NEAR(u.y, -0.18e-3, 1e-12);
  EXPECT_NEAR(u.z, -0.12e-3, 1e-12);
}

TEST(SpaceScene, AtRestTheFieldIsLinear) {
  for (const std::string element : {"p1", "p1_averaged", "p2"}) {
    Simulation simulation(MPI_COMM_WORLD, scene_of(pulled, {"tissue.formulation=" + element}),
                          false);
    run_to_end(simulation);
    expect_pulled(simulation);
    EXPECT_NEAR(simulation.largest_strain().anywhere.value, 0.01, 1e-9);
  }
}

TEST(SpaceScene, LongImplicitStepsComeToRestThere) {
  for (const std::string element : {"p1", "p1_averaged", "p2"}) {
    Simulation simulation(
        MPI_COMM_WORLD,
        scene_of(pulled, {"time={method: implicit, step: 1000 s, duration: 5000 s}",
                          "tissue.formulation=" + element}),
        true);
    run_to_end(simulation);
    expect_pulled(simulation);
  }
}

// Damped, explicit steps come to rest there too. What their energy balance misses is of the sudden load and
// of second order in the step, as in the plane.
TEST(SpaceScene, DampedExplicitStepsComeToRestThere) {
  for (const std::string element : {"p1", "p1_averaged", "p2"}) {
    double missed[2] = {0, 0};
    for (const std::size_t i : {0U, 1U}) {
      const Scene scene = scene_of(
          pulled, {"time={method: explicit, step: 10 ms, duration: 0.5 s}",
                   std::string("time.safety=") + (i == 0 ? "0.4" : "0.2"),
                   "tissue.damping={mass_factor: 150 1/s}", "tissue.formulation=" + element});
      Simulation simulation(MPI_COMM_WORLD, scene, true);
      run_to_end(simulation);
      expect_pulled(simulation);
      const Energies& e = simulation.energies();
      EXPECT_NEAR(e.external, 600 * 0.06 * 0.04 * 0.8e-3, 1e-9);
      missed[i] = std::abs(e.balance_error()) / e.external;
    }
    EXPECT_LT(missed[1], 2e-3);
    EXPECT_NEAR(std::log2(missed[0] / missed[1]), 2, 0.3);
  }
}

// A tension wave between rollers: u_x = A sin(pi x / L) cos(c_p pi t / L).
void expect_wave(const std::string& time, const std::string& element, double tolerance) {
  const Scene scene = scene_of(R"(
mesh: {box: {size: [10 cm, 2 cm, 2 cm], columns: 10, rows: 2, layers: 2}}
tissue:
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}}
supports: {left: roller, right: roller, bottom: roller, top: roller, back: roller, front: roller}
)",
                               {"time=" + time, "tissue.formulation=" + element});
  Simulation simulation(MPI_COMM_WORLD, scene, false);
  const Mesh& mesh = simulation.mesh();
  Vec u = simulation.state().u.get();
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    set_owned(u, 3 * node, 1e-4 * std::sin(std::numbers::pi * mesh.place(node).x / 0.1));
  }
  run_to_end(simulation);
  const auto middle = *locate(mesh, {0.05, 0.01, 0.01});
  const auto moved = simulation.body().world({&middle, 1})[0] - WorldPlace{0.05, 0.01, 0.01};
  const double c_p = std::sqrt(60e3 * 0.7 / (1.3 * 0.4) / 1000);
  const double exact = 1e-4 * std::cos(c_p * std::numbers::pi * simulation.time() / 0.1);
  EXPECT_NEAR(moved.x, exact, tolerance * 1e-4) << time << " " << element;
  EXPECT_NEAR(moved.y, 0, 2 * tolerance * 1e-4);
  EXPECT_NEAR(moved.z, 0, 2 * tolerance * 1e-4);
}

TEST(SpaceScene, WavesHaveTheirPeriod) {
  for (const std::string element : {"p1", "p1_averaged", "p2"}) {
    // Near half a period, 11.13 ms.
    expect_wave("{method: implicit, scheme: average_acceleration, step: 0.1 ms, duration: 11 ms}",
                element, 0.03);
    expect_wave("{method: explicit, step: 0.1 ms, duration: 11 ms}", element, 0.03);
  }
}

TEST(SpaceScene, PrescribedSurfacesMoveAndTellTheirForce) {
  Simulation simulation(
      MPI_COMM_WORLD,
      scene_of(pulled,
               {"loads=null", "prescribed=[{surface: right, displacement: [0.8 mm, null, null]}]"}),
      false);
  run_to_end(simulation);
  expect_pulled(simulation);
  const Vector3 force = simulation.body().curve_reaction(0);
  EXPECT_NEAR(force.x, 600 * 0.06 * 0.04, 1e-9);
  EXPECT_EQ(force.y, 0);
  EXPECT_EQ(force.z, 0);
}

TEST(SpaceScene, BodyForceIsCarriedByTheSupports) {
  // Hung up at its top: the displacement under its own weight is known, rho g H^2 / (2 E), if all other
  // sides are rollers or free and nu is 0.
  Simulation simulation(
      MPI_COMM_WORLD,
      scene_of(pulled, {"loads={body: [{force: [0 N/m^3, -9810 N/m^3, 0 N/m^3]}]}",
                        "supports={top: roller, left: roller, back: roller}",
                        "tissue.regions.tissue.poisson_ratio=0", "mesh.box.rows=12"}),
      false);
  run_to_end(simulation);
  const auto bottom = *locate(simulation.mesh(), {0.04, 0, 0.02});
  const auto moved = simulation.body().world({&bottom, 1})[0] - WorldPlace{0.04, 0, 0.02};
  EXPECT_NEAR(moved.y, -9810 * 0.06 * 0.06 / (2 * 60e3), 0.01 * 9810 * 0.06 * 0.06 / (2 * 60e3));
}

TEST(SpaceScene, QuadraticTetrahedraHangUnderTheirWeightExactly) {
  Simulation simulation(
      MPI_COMM_WORLD,
      scene_of(pulled, {"loads={body: [{force: [0 N/m^3, -9810 N/m^3, 0 N/m^3]}]}",
                        "supports={top: roller, left: roller, back: roller}",
                        "tissue.regions.tissue.poisson_ratio=0", "tissue.formulation=p2",
                        "probes={a: [8 cm, 0 cm, 4 cm], b: [3.1 cm, 2.2 cm, 1.3 cm]}"}),
      false);
  run_to_end(simulation);
  const auto world = simulation.body().world(simulation.probes());
  for (std::size_t i = 0; i < world.size(); ++i) {
    const double y = simulation.probes()[i].x.y;
    const double exact = -9810 * (0.06 * 0.06 - y * y) / (2 * 60e3);
    EXPECT_NEAR(world[i].y - y, exact, 1e-12);
  }
}

std::string refusal(const std::vector<std::string>& changes, const std::string& scene = pulled) {
  try {
    Simulation simulation(MPI_COMM_WORLD, scene_of(scene, changes), false);
    return "no error";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(SpaceScene, WhatIsOfThePlaneIsRefusedByName) {
  EXPECT_EQ(refusal({}), "no error");
  EXPECT_THAT(refusal({"tissue.plane=strain"}),
              AllOf(HasSubstr("key 'tissue.plane'"), HasSubstr("mesh.box is in space")));
  EXPECT_THAT(refusal({"tissue.thickness=1 cm"}),
              AllOf(HasSubstr("key 'tissue.thickness'"), HasSubstr("only with tissue.plane")));
  EXPECT_THAT(refusal({"needles=[{height: 3 cm, cutting: {cutting_force: 1 N}, motion: [{insert: "
                       "{speed: 1 cm/s, depth: 1 cm}}]}]",
                       "time={method: quasi_static}"}),
              AllOf(HasSubstr("key 'needles.0.height'"), HasSubstr("only with tissue.plane")));
  EXPECT_THAT(refusal({"targets={t: [1 cm, 1 cm]}"}), HasSubstr("key 'targets.t'"));
  EXPECT_THAT(
      refusal({"membrane={polygon: [[0 m, 0 m], [1 cm, 0 m], [0 m, 1 cm]], puncture_force: 1 N}"}),
      HasSubstr("key 'membrane.polygon'"));
  EXPECT_THAT(refusal({"procedure={file: a.yaml}"}), HasSubstr("not yet in space"));
  EXPECT_THAT(refusal({"needle_angle=90 deg"}), HasSubstr("key 'needle_angle'"));
  EXPECT_THAT(refusal({"loads.traction.0={curve: right, force: [1 N/m, 0 N/m]}"}),
              AllOf(HasSubstr("key 'loads.traction.0.curve'"), HasSubstr("a surface")));
  EXPECT_THAT(refusal({"loads.traction.0={surface: right, force: [1 N/m, 0 N/m]}"}),
              AllOf(HasSubstr("key 'loads.traction.0.force'"), HasSubstr("stress, in Pa")));
  EXPECT_THAT(refusal({"probes.corner=[8 cm, 6 cm]"}),
              AllOf(HasSubstr("key 'probes.corner'"), HasSubstr("[x, y, z]")));
  EXPECT_THAT(refusal({"probes.corner=[8 cm, 6 cm, 5 cm]"}),
              AllOf(HasSubstr("key 'probes.corner': (0.08, 0.06, 0.05) m lies outside"),
                    HasSubstr("(0, 0, 0) m to (0.08, 0.06, 0.04) m")));
  EXPECT_THAT(refusal({"prescribed=[{surface: top, displacement: [1 mm, null]}]"}),
              HasSubstr("key 'prescribed.0.displacement'"));
  EXPECT_THAT(refusal({"supports.side=fixed"}),
              HasSubstr("no surface named 'side'; the mesh has: left, right, bottom, top, back, "
                        "front"));
}

TEST(SpaceScene, WhatIsOfSpaceIsRefusedInThePlane) {
  const std::string plane = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 4, rows: 3}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}}
supports: {left: fixed}
probes: {corner: [8 cm, 6 cm]}
time: {method: quasi_static}
)";
  EXPECT_EQ(refusal({}, plane), "no error");
  EXPECT_THAT(refusal({"tissue.plane=null"}, plane),
              HasSubstr("key 'tissue.plane': missing; allowed: stress, strain"));
  EXPECT_THAT(refusal({"probes.corner=[8 cm, 6 cm, 0 cm]"}, plane),
              AllOf(HasSubstr("key 'probes.corner'"), HasSubstr("[x, y], because")));
  EXPECT_THAT(refusal({"loads={traction: [{curve: right, stress: [1 Pa, 0 Pa, 0 Pa]}]}"}, plane),
              AllOf(HasSubstr("key 'loads.traction.0.stress'"), HasSubstr("force, in N/m")));
  EXPECT_THAT(refusal({"tissue.formulation=p2"}, plane),
              AllOf(HasSubstr("key 'tissue.formulation'"), HasSubstr("allowed: p1, p1_averaged"),
                    HasSubstr("an element of space")));
  EXPECT_THAT(refusal({"prescribed=[{surface: right, displacement: [1 mm, null]}]"}, plane),
              AllOf(HasSubstr("key 'prescribed.0.surface'"), HasSubstr("a curve")));
}

// Every rigid motion that supports leave free is named.
TEST(SpaceScene, TissueThatIsNotHeldIsRefused) {
  const auto supports = [](const std::string& given) { return refusal({"supports=" + given}); };
  EXPECT_EQ(supports("{left: fixed}"), "no error");
  EXPECT_THAT(supports("{left: roller}"), HasSubstr("from moving along y"));
  EXPECT_THAT(supports("{left: roller, top: roller}"), HasSubstr("from moving along z"));
  EXPECT_EQ(supports("{left: roller, top: roller, front: roller}"), "no error");
  EXPECT_THAT(refusal({"loads=null", "mesh.box.jitter=0", "supports={}",
                       "prescribed=[{surface: left, displacement: [1 mm, null, null]}]"}),
              HasSubstr("from moving along y"));
  EXPECT_THAT(supports("{right: free}"), HasSubstr("from moving along x"));
}

TEST(SpaceScene, LockingIsNoted) {
  // p1_averaged is the default where p1 would lock.
  EXPECT_EQ(scene_of(pulled).tissue.formulation, Formulation::p1);
  EXPECT_EQ(scene_of(pulled, {"tissue.regions.tissue.poisson_ratio=0.49"}).tissue.formulation,
            Formulation::p1_averaged);
}

}  // namespace
}  // namespace stylet
