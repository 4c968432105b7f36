// Order in time, on the free vibration of a small body in its first modes against their closed form
// with Rayleigh damping.
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/implicit_newmark.hpp"

#include "support/modes.hpp"
#include <gtest/gtest.h>

#include <memory>
#include <ostream>

namespace stylet {
namespace {

constexpr int n_modes = 3;

struct TimeCase {
  std::string name;
  TimeParameters time;
  RayleighDamping
      damping;  ///< in units of the first mode: mass_factor of omega, stiffness of 1/omega
  int order;
  friend std::ostream& operator<<(std::ostream& out, const TimeCase& c) { return out << c.name; }
};

// q'' + 2 zeta omega q' + omega^2 q = 0 from q = 1, q' = 0.
double exact_amplitude(double omega, const RayleighDamping& d, double t) {
  const double half = 0.5 * (d.mass_factor + d.stiffness_factor * omega * omega);
  const double damped = std::sqrt(omega * omega - half * half);
  return std::exp(-half * t) * (std::cos(damped * t) + half / damped * std::sin(damped * t));
}

// Largest error of a dof after one period of the first mode.
double error(const TimeCase& c, int steps) {
  const bool is_explicit = c.time.method == TimeMethod::explicit_newmark;
  const auto kind = is_explicit ? MassKind::lumped : MassKind::consistent;
  const Grid grid{.width = 1, .height = 0.8, .columns = 4, .rows = 3, .jitter = 0.1};
  auto parameters = material({1, 0.3, 1}, Plane::strain, kind);
  const Slab undamped(rectangle(grid), parameters);
  const auto supports = dofs_of(undamped.mesh, {"left"});
  const auto modes = dense_modes(undamped.tissue, supports);
  const double first = std::sqrt(modes.squares[0]);
  const RayleighDamping damping{c.damping.mass_factor * first, c.damping.stiffness_factor / first};
  parameters.damping = damping;
  Slab body(rectangle(grid), parameters);
  std::unique_ptr<TimeIntegrator> integrator;
  if (is_explicit) {
    integrator = std::make_unique<ExplicitNewmark>(body.tissue, body.mesh, c.time);
  } else {
    integrator = std::make_unique<ImplicitNewmark>(body.tissue, c.time);
  }
  const double end = 2 * 3.141592653589793 / first;
  const auto sum = [&](double t) {
    std::vector<double> u(static_cast<std::size_t>(body.tissue.n_dofs()), 0.0);
    for (std::size_t i = 0; i < n_modes; ++i) {
      const double q = exact_amplitude(std::sqrt(modes.squares[i]), damping, t);
      for (std::size_t dof = 0; dof < u.size(); ++dof) u[dof] += q * modes.shapes[i][dof];
    }
    return u;
  };
  State state = still(body.tissue);
  state.u = vector_of(body.tissue, sum(0));
  OwnedVec load = body.tissue.make_vector();
  check(VecSet(load.get(), 0));
  const auto constraints = held(supports);
  initial_acceleration(body.tissue, state, load.get(), constraints);
  for (int n = 0; n < steps; ++n) step(*integrator, state, load.get(), end / steps, constraints);
  const auto wanted = sum(end);
  const auto found = gather_all(state.u.get());
  double worst = 0;
  for (std::size_t dof = 0; dof < found.size(); ++dof) {
    worst = std::max(worst, std::abs(found[dof] - wanted[dof]));
  }
  return worst;
}

TimeParameters implicit(ImplicitScheme scheme, double rho = 0.8) {
  TimeParameters time;
  time.scheme = scheme;
  time.rho_infinity = rho;
  return time;
}

TimeParameters central_difference() {
  TimeParameters time;
  time.method = TimeMethod::explicit_newmark;
  return time;
}

const RayleighDamping none{};
const RayleighDamping both{0.05, 0.02};
const RayleighDamping by_mass{0.1, 0};
const RayleighDamping by_stiffness{0, 0.02};

class TimeOrder : public testing::TestWithParam<TimeCase> {};
INSTANTIATE_TEST_SUITE_P(
    Schemes,
    TimeOrder,
    testing::Values(
        TimeCase{"average", implicit(ImplicitScheme::average_acceleration), none, 2},
        TimeCase{"average_damped", implicit(ImplicitScheme::average_acceleration), both, 2},
        TimeCase{"alpha_0", implicit(ImplicitScheme::generalised_alpha, 0), none, 2},
        TimeCase{"alpha", implicit(ImplicitScheme::generalised_alpha), none, 2},
        TimeCase{"alpha_damped", implicit(ImplicitScheme::generalised_alpha), both, 2},
        TimeCase{"backward_euler", implicit(ImplicitScheme::backward_euler), none, 1},
        TimeCase{"backward_euler_damped", implicit(ImplicitScheme::backward_euler), both, 1},
        TimeCase{"central", central_difference(), none, 2},
        TimeCase{"central_damped_by_mass", central_difference(), by_mass, 2},
        // The damping force lags by half a step (that keeps the mass diagonal): first order.
        TimeCase{"central_damped_by_stiffness", central_difference(), by_stiffness, 1}),
    [](const auto& one) { return one.param.name; });

TEST_P(TimeOrder, IsThatOfTheScheme) {
  const TimeCase& c = GetParam();
  // A third mode with hundreds of steps a period: what the next power of the step leaves in the order
  // is below the tolerance.
  const int steps = c.order == 1 ? 4000 : 1600;
  const double coarse = error(c, steps);
  const double fine = error(c, 2 * steps);
  RecordProperty("order", std::to_string(order(coarse, fine)));
  RecordProperty("error", std::to_string(fine));
  EXPECT_NEAR(order(coarse, fine), c.order, 0.05);
}

}  // namespace
}  // namespace stylet
