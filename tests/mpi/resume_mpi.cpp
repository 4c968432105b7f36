// A simulation goes on from what was stored of it, with the same bits: interrupted at every step, so that
// forgotten state shows.
#include "support/scenes.hpp"
#include <gtest/gtest.h>

#include <cmath>

namespace stylet {
namespace {

const char* const tissue = R"(
mesh:
  rectangle:
    size: [8 cm, 6 cm]
    columns: 16
    rows: 12
    region: surrounding
    inner_regions:
      - {name: gland, polygon: [[2 cm, 2 cm], [5 cm, 2 cm], [5 cm, 4 cm], [2 cm, 4 cm]]}
tissue:
  plane: stress
  regions:
    gland: {youngs_modulus: 60 kPa, poisson_ratio: 0.4, density: 1000 kg/m^3}
    surrounding: {youngs_modulus: 50 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed, top: fixed, bottom: fixed}
membrane: {region: gland, puncture_force: 2 N}
targets: {seed: [4 cm, 3.2 cm]}
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
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
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

class Resume : public testing::TestWithParam<std::vector<std::string>> {
 protected:
  [[nodiscard]] static Scene scene() {
    std::vector<std::string> changes = GetParam();
    const bool is_loaded = changes.back() == "loaded";
    if (is_loaded) changes.pop_back();
    return scene_of(std::string(tissue) + procedure + (is_loaded ? loaded : ""), changes);
  }
};

TEST_P(Resume, InterruptedAtEveryStepItGoesOnWithTheSameBits) {
  Simulation whole(MPI_COMM_WORLD, scene(), true);
  auto part = std::make_unique<Simulation>(MPI_COMM_WORLD, scene(), true);
  int steps = 0;
  while (!whole.done()) {
    const auto expected = whole.step();
    const auto record = part->step();
    ++steps;
    const auto a = numbers_of(whole, expected);
    const auto b = numbers_of(*part, record);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i], b[i]) << "number " << i << " after step " << steps << ", at t = " << record.t;
    }
    ASSERT_EQ(whole.done(), part->done());
    if (whole.done()) break;
    whole.restore(whole.store());
    auto stored = part->store();
    part = std::make_unique<Simulation>(MPI_COMM_WORLD, scene(), true);
    part->restore(std::move(stored));
  }
  EXPECT_GT(steps, 50);
}

// Operator, factor and kernels are made anew: what differs is round-off.
TEST_P(Resume, StoringChangesNothing) {
  Simulation plain(MPI_COMM_WORLD, scene(), true);
  Simulation stored(MPI_COMM_WORLD, scene(), true);
  while (!plain.done()) {
    const auto expected = plain.step();
    const auto record = stored.step();
    if (!stored.done()) stored.restore(stored.store());
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

}  // namespace
}  // namespace stylet
