// A simulation goes on from what was stored of it, with the same bits: interrupted at every step on
// one rank, so that forgotten state shows.
#include "stylet/base/errors.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/procedure_log.hpp"
#include "stylet/simulation/recorded.hpp"

#include "support/needles_in_space.hpp"
#include "support/scenes.hpp"
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>

namespace stylet {
namespace {

const char* const damping = "tissue.damping.stiffness_factor=0.05 s";

const std::string tissue = two_regions + R"(targets: {seed: [4 cm, 3.2 cm]}
probes: {inside: [3 cm, 3 cm]}
)";

const char* const procedure = R"(
needles:
  - height: 3.2 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion:
      - insert: {speed: 20 cm/s, depth: 4 cm}
      - hold: {duration: 20 ms}
      - implant
      - retract: {speed: 30 cm/s, depth: 2 cm}
      - insert: {speed: 20 cm/s, depth: 3 cm}
      - retract: {speed: 30 cm/s}
      - settle: {duration: 30 ms}
  - height: 3.22 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s, viscous_coefficient: 200 N s/m^2}
    motion:
      - insert: {speed: 20 cm/s, depth: 3 cm}
      - retract: {speed: 30 cm/s}
      - settle: {duration: 20 ms}
)";

const char* const loaded = R"(
loads:
  body: [{force: [0 N/m^3, -500 N/m^3]}]
  traction: [{curve: right, force: [20 N/m, 0 N/m], start: 60 ms}]
)";

/// All that a step leaves.
std::vector<double> numbers_of(const Simulation& simulation, const StepRecord& step) {
  const Energies& e = simulation.energies();
  std::vector<double> all{step.t,
                          step.h,
                          static_cast<double>(step.passes),
                          static_cast<double>(step.iterations),
                          step.needle.forces.tip,
                          step.needle.forces.friction,
                          step.needle.work,
                          static_cast<double>(step.needle.n_stick),
                          static_cast<double>(step.needle.n_slip),
                          e.kinetic,
                          e.strain,
                          e.dissipated,
                          e.external,
                          e.edits,
                          static_cast<double>(simulation.counts().edge_flips),
                          static_cast<double>(simulation.counts().needle.hand_overs),
                          simulation.counts().worst_quality,
                          simulation.counts().stable_step,
                          simulation.counts().peak_needle_force,
                          simulation.largest_strain().widespread.value};
  for (const Vec field : {simulation.state().u.get(), simulation.state().v.get()}) {
    const auto values = gather_all(field);
    all.insert(all.end(), values.begin(), values.end());
  }
  const auto& coordinates = simulation.mesh().data().coordinates;
  all.insert(all.end(), coordinates.begin(), coordinates.end());
  return all;
}

using Make = std::function<std::unique_ptr<Simulation>()>;

/// Steps: every one on one rank; of several ranks each makes less of it, and all wait for each other.
int between_interruptions() {
  const int n_ranks = size_of(MPI_COMM_WORLD);
  return n_ranks == 1 ? 1 : 2 * n_ranks - 1;
}

/// The same numbers after every step, whether it goes on or is made anew. Returns the steps.
int interrupt_every_step(const Make& make) {
  const int interval = between_interruptions();
  const auto whole = make();
  auto part = make();
  int steps = 0;
  while (!whole->done()) {
    const auto expected = whole->step();
    const auto record = part->step();
    ++steps;
    const auto a = numbers_of(*whole, expected);
    const auto b = numbers_of(*part, record);
    EXPECT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i], b[i]) << "number " << i << " after step " << steps << ", at t = " << record.t;
      if (a[i] != b[i]) return steps;
    }
    EXPECT_EQ(whole->done(), part->done());
    if (whole->done() || part->done()) break;
    if (steps % interval != 0) continue;
    whole->restore(whole->store());
    auto stored = part->store();
    part = make();
    part->restore(std::move(stored));
  }
  return steps;
}

class Resume : public testing::TestWithParam<std::vector<std::string>> {
 protected:
  [[nodiscard]] static Scene scene() {
    std::vector<std::string> changes = GetParam();
    const bool is_loaded = changes.back() == "loaded";
    if (is_loaded) changes.pop_back();
    changes.insert(changes.begin(), damping);
    return scene_of(tissue + procedure + (is_loaded ? loaded : ""), changes);
  }
};

TEST_P(Resume, InterruptedAtEveryStepItGoesOnWithTheSameBits) {
  const int steps = interrupt_every_step(
      [] { return std::make_unique<Simulation>(MPI_COMM_WORLD, scene(), true); });
  EXPECT_GT(steps, 50);
}

// Operator, factor and kernels are made anew: what differs is round-off.
TEST_P(Resume, StoringChangesNothing) {
  Simulation plain(MPI_COMM_WORLD, scene(), true);
  Simulation stored(MPI_COMM_WORLD, scene(), true);
  const int interval = 4 * between_interruptions();
  for (int steps = 1; !plain.done(); ++steps) {
    const auto expected = plain.step();
    const auto record = stored.step();
    if (!stored.done() && steps % interval == 0) stored.restore(stored.store());
    ASSERT_EQ(expected.t, record.t);
    ASSERT_NEAR(expected.needle.forces.total(), record.needle.forces.total(), 1e-8);
    ASSERT_EQ(expected.needle.n_stick, record.needle.n_stick) << record.t;
  }
  EXPECT_TRUE(stored.done());
  const auto u = gather_all(plain.state().u.get());
  const auto v = gather_all(stored.state().u.get());
  double largest = 0;
  for (std::size_t i = 0; i < u.size(); ++i) largest = std::max(largest, std::abs(u[i] - v[i]));
  EXPECT_LT(largest, 1e-12);
  EXPECT_EQ(plain.counts().needle.hand_overs, stored.counts().needle.hand_overs);
}

INSTANTIATE_TEST_SUITE_P(
    Methods,
    Resume,
    testing::Values(
        std::vector<std::string>{"time.step=5 ms"},
        std::vector<std::string>{"time.step=5 ms", "time.scheme=average_acceleration"},
        std::vector<std::string>{"time.step=5 ms", "time.scheme=generalised_alpha", "loaded"},
        std::vector<std::string>{"time.step=5 ms", "time.method=quasi_static"},
        std::vector<std::string>{"time.step=5 ms", "time.method=quasi_static", "loaded"},
        std::vector<std::string>{"time.step=5 ms", "time.method=explicit",
                                 "tissue.damping.stiffness_factor=null",
                                 "tissue.damping.mass_factor=50 1/s"},
        std::vector<std::string>{"time.step=5 ms", "time.method=explicit",
                                 "tissue.damping.stiffness_factor=0.02 ms", "loaded"}));

const char* const in_space = R"(
mesh: {box: {size: [4 cm, 3 cm, 2 cm], columns: 4, rows: 3, layers: 2, jitter: 0.2}}
tissue:
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
  formulation: p1_averaged
supports: {left: fixed, bottom: roller}
loads: {body: [{force: [0 N/m^3, 0 N/m^3, -1 kN/m^3]}]}
prescribed: [{surface: right, displacement: [null, null, 1 mm], ramp: 20 ms}]
probes: {inside: [1.3 cm, 1.9 cm, 0.7 cm]}
)";

TEST(ResumeInSpace, GoesOnWithTheSameBits) {
  for (const std::string element : {"p1_averaged", "p2"}) {
    for (const std::string time :
         {"{method: implicit, step: 5 ms, duration: 40 ms}",
          "{method: implicit, scheme: generalised_alpha, step: 5 ms, duration: 40 ms}",
          "{method: quasi_static, step: 5 ms, duration: 40 ms}",
          "{method: explicit, step: 2 ms, duration: 10 ms}"}) {
      const Scene scene = scene_of(in_space, {"time=" + time, "tissue.formulation=" + element});
      const int steps = interrupt_every_step(
          [&] { return std::make_unique<Simulation>(MPI_COMM_WORLD, scene, true); });
      EXPECT_GE(steps, 5) << time;
    }
  }
}

TEST(ResumeInSpace, NeedlesGoOnWithTheSameBits) {
  for (const std::string time :
       {"{method: implicit, step: 5 ms}",
        "{method: implicit, scheme: average_acceleration, step: 5 ms}",
        "{method: explicit, step: 5 ms}", "{method: quasi_static, step: 5 ms}"}) {
    const Scene scene = scene_of(needles_in_space, {"time=" + time});
    const int steps = interrupt_every_step(
        [&] { return std::make_unique<Simulation>(MPI_COMM_WORLD, scene, true); });
    EXPECT_GT(steps, 60) << time;
  }
}

ProcedureRow move(double speed, double duration) {
  ProcedureRow row{ProcedureRow::Kind::move};
  row.speed = speed;
  row.duration = duration;
  return row;
}

ProcedureRow change(const std::string& key, double value) {
  ProcedureRow row{ProcedureRow::Kind::change};
  row.key = key;
  row.value = value;
  return row;
}

ProcedureRow enter(double height, CuttingLaw law) {
  ProcedureRow row{ProcedureRow::Kind::enter};
  row.needle.name = "needle" + std::to_string(height);
  row.needle.height = height;
  row.needle.cutting.law = law;
  row.needle.cutting.cutting_force = 1.7;
  row.needle.cutting.tip_length = 6e-3;
  row.needle.friction = FrictionParameters{195, 130, 1e-3, 1.5e-3};
  return row;
}

/// Two needles that the scene does not know, and every kind of change between and within moves.
std::vector<ProcedureRow> rows_of(TimeMethod method) {
  const CuttingLaw law =
      method == TimeMethod::explicit_newmark ? CuttingLaw::lagged : CuttingLaw::consistent;
  std::vector<ProcedureRow> rows{move(0, 0.01),
                                 enter(0.032, law),
                                 move(0.2, 0.1),
                                 change("tissue.regions.gland.youngs_modulus", 50e3),  // all alike
                                 change("needle.cutting.cutting_force", 1.5),
                                 move(0.2, 0.03),
                                 change("tissue.regions.gland.youngs_modulus", 80e3),
                                 change("membrane.puncture_force", 1.8),
                                 change("needle.friction.kinetic_force", 120),
                                 move(0.15, 0.031)};
  if (method != TimeMethod::quasi_static) rows.push_back(change("tissue.damping.mass_factor", 20));
  for (const auto& row : {move(0.15, 0.02), move(-0.3, 0.25), enter(0.0322, law), move(0.2, 0.06),
                          move(-0.3, 0.08), move(0, 0.02)}) {
    rows.push_back(row);
  }
  return rows;
}

class ResumeRecorded : public testing::TestWithParam<std::vector<std::string>> {};

TEST_P(ResumeRecorded, ChangesInMidRunAreRemembered) {
  std::vector<std::string> changes = GetParam();
  changes.insert(changes.begin(), damping);
  changes.emplace_back("time.duration=1 s");
  const Scene scene = for_live_hand(scene_of(tissue, changes));
  const int steps = interrupt_every_step([&] {
    return std::make_unique<Simulation>(MPI_COMM_WORLD, scene, true,
                                        std::make_unique<Recorded>(rows_of(scene.time.method)));
  });
  EXPECT_GT(steps, 100);
}

TEST(ResumeRecordedRows, AreThoseOfBefore) {
  const Scene scene = for_live_hand(scene_of(tissue, {"time.step=5 ms", "time.duration=1 s"}));
  const auto make = [&](std::vector<ProcedureRow> rows) {
    return std::make_unique<Simulation>(MPI_COMM_WORLD, scene, true,
                                        std::make_unique<Recorded>(std::move(rows)));
  };
  const auto one = make({move(0, 0.02)});
  one->step();
  const auto other = make({move(0, 0.03)});
  EXPECT_THROW(other->restore(one->store()), InputError);
}

INSTANTIATE_TEST_SUITE_P(
    Methods,
    ResumeRecorded,
    testing::Values(std::vector<std::string>{"time.step=5 ms"},
                    std::vector<std::string>{"time.step=5 ms", "time.method=quasi_static",
                                             "tissue.damping=null"},
                    std::vector<std::string>{"time.step=5 ms", "time.method=explicit",
                                             "tissue.damping.stiffness_factor=null",
                                             "tissue.damping.mass_factor=50 1/s"}));

}  // namespace
}  // namespace stylet
