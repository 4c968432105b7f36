// Which explicit steps are stable, what they store, and what of it is right.
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

double stable_step(double omega_squared, double stiffness_factor) {
  const double omega = std::sqrt(omega_squared);
  const double xi = 0.5 * stiffness_factor * omega;
  // 2 (sqrt(1 + xi^2) - xi) / omega without cancellation.
  return 2 / (omega * (std::sqrt(1 + xi * xi) + xi));
}

StoredEnergy ExplicitNewmark::energy(const State& state) {
  cells_.stiffness(state.u.get(), work_.get());
  double twice[2] = {0, 0};
  {
    const Values u(state.u.get());
    const Values v(state.v.get());
    const Values force(work_.get());
    const auto dim = static_cast<std::size_t>(tissue_.dim());
    for (std::size_t i = 0; i < dim * node_mass_.size(); ++i) {
      twice[0] += node_mass_[i / dim] * v.data()[i] * v.data()[i];
      twice[1] += u.data()[i] * force.data()[i];
    }
  }
  if (size_of(tissue_.comm()) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, twice, 2, MPI_DOUBLE, MPI_SUM, tissue_.comm());
  }
  return {0.5 * twice[0], 0.5 * twice[1] + track_.energy()};
}

// Central difference conserves 1/2 v M v + 1/2 u K u - h^2/8 a M a. With (omega h)^2 / 4 up to safety^2
// the first two alone swing above it by 1 / (1 - safety^2); unstable steps conserve it too, while all
// three grow.
EnergyRules ExplicitNewmark::energy_rules() const {
  constexpr int interval = 20;  // a K product in twenty steps costs below 5 %
  constexpr double most = 0.9;
  return {
      .interval = interval,
      .largest_swing = 1 / (1 - std::pow(std::min(safety_, most), 2)),
      .advice = "a smaller time.safety, a finer mesh, or time.method implicit",
      // Implicit steps relax what an interpolated field adds; explicit ones carry it on as waves.
      .edits_advice =
          "this tissue is too close to incompressible, or its elements too large, for "
          "explicit steps; take time.method implicit"};
}

}  // namespace stylet
