// Numbers that change in mid-run.
#include "stylet/simulation/change.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/gather.hpp"

#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace stylet {
namespace {

/// A strip that hangs from its top: a uniform load, and one region, or two alike.
const char* const strip = R"(
mesh:
  rectangle:
    size: [4 cm, 4 cm]
    columns: 8
    rows: 8
    region: upper
    inner_regions: [{name: lower, polygon: [[0 cm, 0 cm], [4 cm, 0 cm], [4 cm, 2 cm], [0 cm, 2 cm]]}]
tissue:
  plane: stress
  regions:
    upper: {youngs_modulus: 20 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}
    lower: {youngs_modulus: 20 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}
supports: {top: fixed}
loads: {body: [{force: [0 N/m^3, -9810 N/m^3]}]}
probes: {end: [2 cm, 0 cm]}
)";

const std::string quasi_static = "time: {step: 10 ms, duration: 1 s, method: quasi_static}\n";
const std::string backward = "time: {step: 0.5 ms, duration: 1 s}\n";
const std::string average = "time: {step: 0.5 ms, duration: 1 s, scheme: average_acceleration}\n";
const std::string central = "time: {step: 0.5 ms, duration: 1 s, method: explicit}\n";

double sag(const Simulation& simulation) {
  return simulation.body().world(simulation.probes()).front().y;
}

void pass(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) simulation.step();
}

/// Both regions at once.
bool stiffen(Simulation& simulation, double modulus) {
  const bool upper = simulation.change("tissue.regions.upper.youngs_modulus", modulus);
  return simulation.change("tissue.regions.lower.youngs_modulus", modulus) && upper;
}

TEST(Change, TwiceTheStiffnessHalvesTheDisplacement) {
  Simulation simulation(MPI_COMM_WORLD, scene_of(strip + quasi_static), true);
  pass(simulation, 2);
  const double soft = sag(simulation);
  const double strain = simulation.energies().strain;
  EXPECT_LT(soft, -1e-4);
  EXPECT_TRUE(stiffen(simulation, 40e3));
  EXPECT_EQ(sag(simulation), soft);  // between steps nothing moves
  EXPECT_NEAR(simulation.energies().strain, 2 * strain, 1e-10 * strain);
  pass(simulation, 1);
  EXPECT_NEAR(sag(simulation), 0.5 * soft, 1e-10 * std::abs(soft));
  EXPECT_NEAR(simulation.energies().strain, 0.5 * strain, 1e-9 * strain);
  stiffen(simulation, 20e3);
  pass(simulation, 1);
  EXPECT_NEAR(sag(simulation), soft, 1e-10 * std::abs(soft));
}

TEST(Change, IsWhatASceneOfThatTissueHas) {
  Simulation changed(MPI_COMM_WORLD, scene_of(strip + quasi_static), false);
  pass(changed, 1);
  EXPECT_TRUE(changed.change("tissue.regions.lower.youngs_modulus", 5e3));
  pass(changed, 1);
  Simulation made(MPI_COMM_WORLD,
                  scene_of(strip + quasi_static, {"tissue.regions.lower.youngs_modulus=5 kPa"}),
                  false);
  pass(made, 2);
  EXPECT_NEAR(sag(changed), sag(made), 1e-10 * std::abs(sag(made)));
}

class DynamicChange : public testing::TestWithParam<std::string> {};

// What the change puts in is in the balance: the run does not end, and nothing is left over but what
// the scheme itself damps.
TEST_P(DynamicChange, KeepsTheBalanceOfEnergy) {
  Simulation simulation(MPI_COMM_WORLD, scene_of(strip + GetParam()), true);
  pass(simulation, 100);
  const Energies before = simulation.energies();
  ASSERT_GT(before.strain, 0);
  stiffen(simulation, 60e3);
  const Energies after = simulation.energies();
  const double added = after.external - before.external;
  EXPECT_NEAR(after.strain, 3 * before.strain, 1e-9 * before.strain);
  EXPECT_NEAR(after.kinetic, before.kinetic, 1e-9 * before.kinetic);
  const bool is_explicit = simulation.scene().time.method == TimeMethod::explicit_newmark;
  // Central difference conserves kinetic and strain energy less h^2/8 a M a.
  EXPECT_NEAR(added, 2 * before.strain, (is_explicit ? 0.1 : 1e-9) * before.strain);
  pass(simulation, 200);
  const Energies end = simulation.energies();
  const double scale = after.external;
  const double lost = end.balance_error() - before.balance_error();
  EXPECT_GT(lost, -0.02 * scale);
  if (simulation.scene().time.scheme != ImplicitScheme::backward_euler || is_explicit) {
    EXPECT_LT(lost, 0.02 * scale);
  }
  EXPECT_LE(simulation.body().ledger().worst_excess(), 0.05);
}

TEST_P(DynamicChange, BeforeTheFirstStepIsAnotherScene) {
  const std::vector<std::string> stiff{"tissue.regions.upper.youngs_modulus=60 kPa",
                                       "tissue.regions.lower.youngs_modulus=60 kPa"};
  Simulation changed(MPI_COMM_WORLD, scene_of(strip + GetParam()), false);
  stiffen(changed, 60e3);
  Simulation made(MPI_COMM_WORLD, scene_of(strip + GetParam(), stiff), false);
  for (int i = 0; i < 5; ++i) {
    pass(changed, 20);
    pass(made, 20);
    EXPECT_NEAR(sag(changed), sag(made), 1e-9 * std::abs(sag(made))) << i;
  }
}

// The steps after a change of stiffness are damped where the scheme keeps waves.
TEST_P(DynamicChange, ThereAndBackIsNone) {
  Simulation changed(MPI_COMM_WORLD, scene_of(strip + GetParam()), false);
  Simulation plain(MPI_COMM_WORLD, scene_of(strip + GetParam()), false);
  const bool keeps_waves = plain.scene().time.method == TimeMethod::implicit_newmark &&
                           plain.scene().time.scheme != ImplicitScheme::backward_euler;
  double most = 0;
  for (int i = 0; i < 5; ++i) {
    pass(changed, 20);
    pass(plain, 20);
    most = std::max(most, std::abs(sag(plain)));
    EXPECT_NEAR(sag(changed), sag(plain), (keeps_waves ? 0.02 : 1e-9) * most) << i;
    stiffen(changed, 60e3);
    stiffen(changed, 20e3);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, DynamicChange, testing::Values(backward, average, central));

TEST(Change, OfDampingBringsTheStripToRest) {
  for (const std::string& time : {backward, central}) {
    Simulation simulation(MPI_COMM_WORLD, scene_of(strip + time), true);
    pass(simulation, 100);
    const bool is_implicit = simulation.scene().time.method == TimeMethod::implicit_newmark;
    EXPECT_EQ(simulation.change("tissue.damping.mass_factor", 200), is_implicit);
    pass(simulation, 1500);
    EXPECT_LT(simulation.body().largest_speed(), 1e-3);
    EXPECT_GT(simulation.energies().dissipated, 0);
    Simulation at_rest(MPI_COMM_WORLD, scene_of(strip + quasi_static), false);
    pass(at_rest, 1);
    EXPECT_NEAR(sag(simulation), sag(at_rest), 0.01 * std::abs(sag(at_rest)));
  }
}

TEST(Change, OfTheCuttingForceIsTheForceOfTheTip) {
  Simulation simulation(MPI_COMM_WORLD, reference_scene(), false);
  StepRecord step;
  const auto go_to = [&](double time) {
    while (simulation.time() < time) step = simulation.step();
  };
  go_to(0.8);
  EXPECT_NEAR(step.needle.forces.tip, 1.7, 1e-3);
  EXPECT_FALSE(simulation.change("needle.cutting.cutting_force", 1.2));
  go_to(0.9);
  EXPECT_NEAR(step.needle.forces.tip, 1.2, 1e-3);
  EXPECT_FALSE(simulation.change("needle.cutting.cutting_force", 2.0));
  go_to(1.2);
  EXPECT_NEAR(step.needle.forces.tip, 2.0, 1e-3);
}

TEST(Change, OfFrictionIsTheForceOfTheShaft) {
  Simulation simulation(MPI_COMM_WORLD, reference_scene(), false);
  StepRecord step;
  while (simulation.time() < 1.2) step = simulation.step();
  ASSERT_EQ(step.needle.n_stick, 0);
  // All of the shaft slides, at so much a metre.
  const double length = step.needle.forces.friction / 130;
  const double path = simulation.needle()->path_length();
  simulation.change("needle.friction.kinetic_force", 65);
  simulation.change("needle.friction.static_force", 97.5);
  int steps = 0;
  do step = simulation.step();
  while (step.needle.n_stick > 0 && ++steps < 70);
  ASSERT_EQ(step.needle.n_stick, 0);
  const double now = length + simulation.needle()->path_length() - path;
  EXPECT_NEAR(step.needle.forces.friction, 65 * now, 1e-9);
}

TEST(Change, ThatIsNotAllowedIsRefusedAndChangesNothing) {
  Simulation simulation(MPI_COMM_WORLD, reference_scene(), false);
  while (simulation.time() < 0.3) simulation.step();
  const auto refusal = [&](const std::string& key, double value) -> std::string {
    try {
      simulation.change(key, value);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("tissue.thickness", 1), testing::HasSubstr("does not change in mid-run"));
  EXPECT_THAT(refusal("tissue.regions.prostate.youngs_modulus", 0), testing::HasSubstr("> 0 Pa"));
  EXPECT_THAT(refusal("needle.friction.kinetic_force", 200), testing::HasSubstr("static_force"));
  EXPECT_THAT(refusal("needle.cutting.sharpness", std::nan("")), testing::HasSubstr("allowed"));
  Simulation untouched(MPI_COMM_WORLD, reference_scene(), false);
  while (untouched.time() < 0.3) untouched.step();
  for (int i = 0; i < 30; ++i) {
    simulation.step();
    untouched.step();
  }
  EXPECT_EQ(gather_all(simulation.state().u.get()), gather_all(untouched.state().u.get()));
}

TEST(Change, HasAListForSliders) {
  Simulation simulation(MPI_COMM_WORLD, reference_scene(), false);
  const auto named = [&](const std::string& key) {
    const auto list = changeable(simulation);
    const auto found = std::ranges::find(list, key, &Changeable::key);
    return found == list.end() ? std::optional<Changeable>() : *found;
  };
  EXPECT_FALSE(named("needle.cutting.cutting_force"));
  simulation.step();
  const auto force = named("needle.cutting.cutting_force");
  ASSERT_TRUE(force);
  EXPECT_EQ(force->value, 1.7);
  EXPECT_EQ(force->unit, "N");
  EXPECT_EQ(force->minimum, 0);
  EXPECT_TRUE(force->above_minimum);
  EXPECT_FALSE(force->new_operator);
  const auto modulus = named("tissue.regions.prostate.youngs_modulus");
  ASSERT_TRUE(modulus);
  EXPECT_EQ(modulus->value, 60e3);
  EXPECT_TRUE(modulus->new_operator);
  for (const Changeable& entry : changeable(simulation)) {
    if (std::isfinite(entry.value)) simulation.change(entry.key, entry.value);
  }
}

}  // namespace
}  // namespace stylet
