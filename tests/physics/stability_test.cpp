// Measured stable steps and energies against closed forms of small bodies.
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/modes.hpp"
#include "stylet/study/perturbation.hpp"

#include "support/modes.hpp"
#include "support/scenes.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

const char* const block = R"(mesh: {rectangle: {size: [8 cm, 6 cm], columns: 8, rows: 6}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 3.2 cm
    cutting: {cutting_force: 1.7 N, tip_length: 1 cm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion: [insert: {speed: 2 cm/s, depth: 5 cm}]
time: {step: 20 ms}
output: {history: false}
)";

/// A simulation and a tissue of the study at its present moment.
struct Frozen {
  explicit Frozen(const std::vector<std::string>& overrides = {})
      : simulation(MPI_COMM_WORLD, scene_of(block, overrides), false),
        original(simulation.numbered()) {}

  void freeze(MassKind mass, std::optional<RayleighDamping> damping = {}) {
    TissueParameters parameters = simulation.scene().tissue;
    parameters.mass = mass;
    parameters.damping = damping;
    tissue = tissue_at(MPI_COMM_WORLD, original, simulation.mesh(), parameters);
    held = homogeneous(simulation.constraints());
    v = random_velocities(*tissue, original, held);
  }
  [[nodiscard]] double limit() const {
    return measured_limit(*tissue, simulation.mesh(), held, v.get()).step;
  }
  [[nodiscard]] double predicted() const {
    return measured_limit(*tissue, simulation.mesh(), held, v.get()).predicted;
  }
  [[nodiscard]] EnergyGrowth growth(ImplicitScheme scheme, double rho, double h) const {
    TimeParameters time;
    time.scheme = scheme;
    time.rho_infinity = rho;
    return energy_growth(*tissue, held, v.get(), time, h, 200);
  }

  Simulation simulation;
  NumberedMesh original;
  std::unique_ptr<TissueOperator> tissue;
  ConstraintSet held;
  OwnedVec v;
};

double omega_of(const Frozen& frozen) {
  return std::sqrt(largest_frequency_squared(*frozen.tissue, frozen.held));
}

// The three limits in closed form from the dense spectrum; bisection is good to 0.1 %.
TEST(MeasuredLimit, IsThatOfTheLargestFrequencyOnAUniformMesh) {
  Frozen frozen({"supports.right=fixed", "needles=[]", "time.duration=1 s"});
  frozen.freeze(MassKind::lumped);
  std::vector<int> dofs;
  for (const auto& dof : frozen.held.dofs) dofs.push_back(dof.dof);
  const double omega = std::sqrt(dense_modes(*frozen.tissue, dofs).squares.back());
  EXPECT_NEAR(omega_of(frozen), omega, 1e-6 * omega);
  const double xi = 0.3;
  const double damped = 2 * (std::sqrt(1 + xi * xi) - xi) / omega;
  EXPECT_NEAR(frozen.limit(), 2 / omega, 0.005 * 2 / omega);
  frozen.freeze(MassKind::lumped, RayleighDamping{0.1 * omega, 0});
  EXPECT_NEAR(frozen.limit(), 2 / omega, 0.005 * 2 / omega);
  frozen.freeze(MassKind::lumped, RayleighDamping{0, 2 * xi / omega});
  EXPECT_NEAR(frozen.limit(), damped, 0.005 * damped);
}

TEST(MeasuredLimit, IsNeverBelowThePredictionWhileANeedleGoesIn) {
  Frozen frozen;
  int moment = 0;
  do {
    frozen.freeze(MassKind::lumped);
    const double omega = omega_of(frozen);
    const double limit = frozen.limit();
    EXPECT_LE(frozen.predicted(), limit) << "moment " << moment;
    // Steps much shorter than needed would make interactive runs slow.
    EXPECT_GE(frozen.predicted(), 0.6 * limit) << "moment " << moment;
    EXPECT_NEAR(limit, 2 / omega, 0.005 * limit) << "moment " << moment;
    const double factor = 0.4 / omega;
    frozen.freeze(MassKind::lumped, RayleighDamping{0, factor});
    EXPECT_LE(frozen.predicted(), frozen.limit()) << "moment " << moment;
    for (int i = 0; i < 40 && !frozen.simulation.done(); ++i) frozen.simulation.step();
  } while (++moment < 4);
  EXPECT_GT(frozen.simulation.counts().needle.hand_overs, 2);
}

// Weights M x of the highest mode x are orthogonal to all others: the second highest is left.
TEST(LargestFrequency, RespectsTheMeanCondition) {
  Slab body(rectangle({.columns = 4, .rows = 3, .jitter = 0.2}),
            material({1, 0.3, 1}, Plane::stress, MassKind::lumped));
  const auto supports = dofs_of(body.mesh, {"left"});
  const auto modes = dense_modes(body.tissue, supports);
  ConstraintSet constraints = held(supports);
  const auto mass = gather_all(body.tissue.lumped_mass());
  MeanCondition mean;
  for (std::size_t i = 0; i < mass.size(); ++i) {
    mean.weights.push_back({static_cast<int>(i), mass[i] * modes.shapes.back()[i]});
  }
  constraints.mean = mean;
  const double second = modes.squares[modes.squares.size() - 2];
  EXPECT_NEAR(largest_frequency_squared(body.tissue, constraints), second, 1e-6 * second);
}

class Energies : public testing::TestWithParam<double> {
 protected:
  Energies() {
    for (int i = 0; i < 60; ++i) frozen_.simulation.step();
    frozen_.freeze(MassKind::lumped);
    h_ = GetParam() * 2 / omega_of(frozen_);
    frozen_.freeze(MassKind::consistent);
  }
  Frozen frozen_;
  double h_ = 0;
};

TEST_P(Energies, AverageAccelerationKeepsThem) {
  const auto growth = frozen_.growth(ImplicitScheme::average_acceleration, 1, h_);
  EXPECT_NEAR(growth.last, 1, 1e-6);
  EXPECT_NEAR(growth.largest, 1, 1e-6);
  EXPECT_FALSE(growth.grows);
}

TEST_P(Energies, DampingSchemesLoseThem) {
  for (const auto scheme : {ImplicitScheme::generalised_alpha, ImplicitScheme::backward_euler}) {
    const auto growth = frozen_.growth(scheme, 0.8, h_);
    EXPECT_FALSE(growth.grows);
    EXPECT_LT(growth.last, 1 - 1e-6);
  }
}

class LongSteps : public Energies {};

// A spectral radius above 1 at large steps has to be seen.
TEST_P(LongSteps, GrowthIsSeen) {
  EXPECT_TRUE(frozen_.growth(ImplicitScheme::generalised_alpha, 1.2, h_).grows);
}

INSTANTIATE_TEST_SUITE_P(Steps, LongSteps, testing::Values(1, 1000));
INSTANTIATE_TEST_SUITE_P(Steps, Energies, testing::Values(0.01, 1, 100, 1000));

}  // namespace
}  // namespace stylet
