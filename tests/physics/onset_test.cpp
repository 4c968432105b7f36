// What begins at once, begins alike in every scheme and with every step: curves that are moved, the needle
// at the skin and at a membrane.
#include "support/scenes.hpp"
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>

namespace stylet {
namespace {

struct Scheme {
  std::string name;
  std::vector<std::string> overrides;
  friend std::ostream& operator<<(std::ostream& out, const Scheme& s) { return out << s.name; }
};

Scheme generalised_alpha(const std::string& rho) {
  return {"generalised_alpha_" + std::to_string(static_cast<int>(10 * std::stod(rho))),
          {"time.scheme=generalised_alpha", "time.rho_infinity=" + rho}};
}

const std::vector<Scheme> implicit_schemes{
    {"backward_euler", {"time.scheme=backward_euler"}},
    {"average_acceleration", {"time.scheme=average_acceleration"}},
    generalised_alpha("0"),
    generalised_alpha("0.5"),
    generalised_alpha("0.8"),
    generalised_alpha("1")};

std::vector<std::string> with(std::vector<std::string> all, std::vector<std::string> more) {
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::string name_of_scheme(const testing::TestParamInfo<Scheme>& info) {
  return info.param.name;
}

// The right side is pulled at a constant speed for 250.4 ms, which is inside a step, then stands.
const std::string pulled = R"(
mesh: {rectangle: {size: [7 cm, 4 cm], columns: 14, rows: 8}}
tissue:
  plane: stress
  thickness: 2 cm
  regions: {tissue: {youngs_modulus: 50 kPa, poisson_ratio: 0.3, density: 1100 kg/m^3}}
  damping: {stiffness_factor: 10 ms}
supports: {left: roller, bottom: roller}
prescribed: [{curve: right, displacement: [2 mm, null], ramp: 250.4 ms}]
time: {duration: 500 ms}
)";
constexpr double pull_end = 0.2504;
constexpr double pull_speed = 0.002 / pull_end;
constexpr double area = 0.04 * 0.02;
constexpr double length = 0.07;
constexpr double modulus = 50e3;

class Pulled : public testing::TestWithParam<Scheme> {};

INSTANTIATE_TEST_SUITE_P(Schemes, Pulled, testing::ValuesIn(implicit_schemes), name_of_scheme);

// u = V t x / l solves the equation of motion without acceleration, so once what the start excited is
// gone, with exp(-t / stiffness_factor), the force is E A V (t + stiffness_factor) / l.
TEST_P(Pulled, CurveNeedsTheForceOfTheClosedForm) {
  for (const std::string step : {"5 ms", "1.25 ms", "0.3125 ms"}) {
    Simulation simulation(
        MPI_COMM_WORLD, scene_of(pulled, with(GetParam().overrides, {"time.step=" + step})), false);
    const double stiffness = modulus * area / length;
    const double damping = 0.01;
    double early = 0;
    double moving = 0;
    double standing = 0;
    int n = 0;
    run_to_end(simulation, [&](const StepRecord& record) {
      const double force = simulation.body().curve_reaction(0).x;
      const double ramp = stiffness * pull_speed * (record.t + damping);
      if (++n > 3 && record.t < 0.2) early = std::max(early, std::abs(force - ramp) / ramp);
      if (record.t > 0.2 && record.t < pull_end)
        moving = std::max(moving, std::abs(force / ramp - 1));
      if (record.t > 0.48) standing = std::max(standing, std::abs(force / (stiffness * 0.002) - 1));
    });
    // What waves there are while the damping has not caught up: none of them rings.
    EXPECT_LT(early, 1) << step;
    EXPECT_LT(moving, 1e-4) << step;
    EXPECT_LT(standing, 1e-4) << step;
    RecordProperty("early_" + step.substr(0, step.find(' ')), std::to_string(early));
    RecordProperty("moving_ppm_" + step.substr(0, step.find(' ')), std::to_string(1e6 * moving));
  }
}

// Mass damping pulls at the tissue on its way: E w'' = alpha rho V x / l besides, with w = 0 at both
// ends, so the force at the end is alpha rho V A l / 3 larger.
TEST(Pulled, CurveNeedsTheForceOfTheClosedFormInExplicitSteps) {
  constexpr double alpha = 300;
  constexpr double density = 1100;
  Simulation simulation(MPI_COMM_WORLD,
                        scene_of(pulled, {"time.method=explicit", "time.step=1 ms",
                                          "tissue.damping={mass_factor: 300 1/s}"}),
                        true);
  double moving = 0;
  run_to_end(simulation, [&](const StepRecord& record) {
    if (record.t < 0.2 || record.t > pull_end) return;
    const double exact = modulus * area / length * pull_speed * record.t +
                         alpha * density * pull_speed * area * length / 3;
    moving = std::max(moving, std::abs(simulation.body().curve_reaction(0).x / exact - 1));
  });
  EXPECT_LT(moving, 2e-3);  // elements: 14 columns, and a Poisson's ratio that the rollers let be
  RecordProperty("moving_ppm", std::to_string(1e6 * moving));
}

const std::string held = R"(
mesh: {rectangle: {size: [7 cm, 5 cm], columns: 14, rows: 10}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 45 kPa, poisson_ratio: 0.45, density: 1050 kg/m^3}}
  damping: {stiffness_factor: 40 ms}
supports: {left: fixed, top: fixed, bottom: fixed}
membrane: {polygon: [[1 cm, 1 cm], [5 cm, 1 cm], [5 cm, 4 cm], [1 cm, 4 cm]], puncture_force: 2.8 N}
needles:
  - height: 2.6 cm
    cutting: {cutting_force: 1.2 N, tip_length: 8 mm}
    friction: {static_force: 60 N/m, kinetic_force: 40 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion: [insert: {speed: 3 cm/s, depth: 3.4 cm}]
)";

struct Hold {
  double time = 0;   ///< s; that the membrane holds the tip
  double force = 0;  ///< N; largest of the tip meanwhile
  double most = 0;   ///< N; largest change of the tip's force between steps before the tip cuts
};

Hold hold_of(const std::vector<std::string>& overrides) {
  Simulation simulation(MPI_COMM_WORLD, scene_of(held, overrides), true);
  Hold hold;
  double last = 0;
  int n = 0;
  run_to_end(simulation, [&](const StepRecord& record) {
    const double force = record.needle.forces.tip;
    if (++n > 2 && record.t < 0.1) hold.most = std::max(hold.most, std::abs(force - last));
    last = force;
    if (!simulation.needle()->at_membrane()) return;
    hold.time += record.h;
    hold.force = std::max(hold.force, force);
  });
  EXPECT_EQ(simulation.counts().needle.punctures, 1);
  return hold;
}

class Held : public testing::TestWithParam<Scheme> {};

INSTANTIATE_TEST_SUITE_P(Schemes, Held, testing::ValuesIn(implicit_schemes), name_of_scheme);

// An overshoot of one step would puncture it at once.
TEST_P(Held, MembraneHoldsTheTipAsLongInEveryScheme) {
  for (const double step : {5e-3, 1.25e-3}) {
    const std::string of_step = "time.step=" + std::to_string(step) + " s";
    static const std::vector<std::string> reference{"time.scheme=backward_euler"};
    const Hold expected = hold_of(with(reference, {of_step}));
    const Hold hold = hold_of(with(GetParam().overrides, {of_step}));
    EXPECT_GT(expected.time, 4 * step);
    EXPECT_NEAR(hold.time, expected.time, 1.01 * step) << step;
    EXPECT_GT(hold.force, 2.6) << step;
    EXPECT_LT(hold.force, 2.8001) << step;
    // What the tip bears before it cuts rises alike.
    EXPECT_NEAR(hold.most, expected.most, 0.05) << step;
  }
}

const std::vector<std::string> explicit_steps{"time.method=explicit",
                                              "tissue.damping={mass_factor: 250 1/s}"};

TEST(Held, MembraneHoldsTheTipInExplicitSteps) {
  // Backward Euler in short steps loses little more than explicit ones.
  const Hold expected =
      hold_of({"tissue.damping={mass_factor: 250 1/s}", "tissue.mass=lumped", "time.step=0.2 ms"});
  const Hold hold = hold_of(with(explicit_steps, {"time.step=1 ms"}));
  EXPECT_NEAR(hold.time, expected.time, 0.3 * expected.time);
  EXPECT_GT(hold.force, 2.6);
  EXPECT_LT(hold.force, 2.8001);
}

// Steps below the stable one, so that the history looks at every one of them.
TEST(Onset, EnergyCheckDoesNotDependOnTheHistory) {
  for (const std::string speed : {"1 cm/s", "4 cm/s", "15 cm/s"}) {
    const auto scene = scene_of(
        held,
        with(explicit_steps, {"time.step=0.1 ms", "membrane=null",
                              "needles.0.motion=[{insert: {speed: " + speed + ", depth: 5 mm}}]"}));
    Simulation with_history(MPI_COMM_WORLD, scene, true);
    Simulation without(MPI_COMM_WORLD, scene, false);
    run_to_end(with_history);
    run_to_end(without);
    EXPECT_EQ(with_history.body().ledger().worst_excess(), without.body().ledger().worst_excess());
    EXPECT_LT(without.body().ledger().worst_excess(), 0.02);
  }
}

TEST(Onset, FirstBlowOfANeedleIsWorkInExplicitSteps) {
  Simulation simulation(MPI_COMM_WORLD,
                        scene_of(held, with(explicit_steps, {"time.step=0.1 ms",
                                                             "needles.0.cutting.tip_length=0 m"})),
                        true);
  simulation.step();
  const Energies& e = simulation.energies();
  EXPECT_GT(e.kinetic, 0);
  EXPECT_NEAR(e.external - e.dissipated, e.kinetic, 1e-10 * e.kinetic);  // round-off
}

// An impulse that counts as a force for a step grows tenfold where the step is a tenth as long.
TEST(Onset, ForceOfTheFirstStepHasALimit) {
  const auto first_force = [](const std::string& step) {
    Simulation simulation(MPI_COMM_WORLD,
                          scene_of(held, {"tissue.damping=null", "needles.0.cutting.tip_length=0 m",
                                          "time.step=" + step}),
                          false);
    return simulation.step().needle.forces.tip;
  };
  const double tenth = first_force("1e-5 s");
  const double hundredth = first_force("1e-6 s");
  EXPECT_GT(hundredth, 0);
  EXPECT_LT(hundredth, tenth);  // without damping the tissue resists more and more
}

TEST(Onset, PeakForceIsThatOfAllSubSteps) {
  const auto peak = [](const std::string& step) {
    Simulation simulation(MPI_COMM_WORLD,
                          scene_of(held, with(explicit_steps, {"time.step=" + step})), false);
    run_to_end(simulation);
    return simulation.counts().peak_needle_force;
  };
  const double often = peak("0.5 ms");
  EXPECT_DOUBLE_EQ(peak("5 ms"), often);
  EXPECT_DOUBLE_EQ(peak("20 ms"), often);
}

}  // namespace
}  // namespace stylet
