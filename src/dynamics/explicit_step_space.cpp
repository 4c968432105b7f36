// The explicit step in space: plain loops around a product with K.
#include "stylet/base/index.hpp"
#include "stylet/dynamics/explicit_step.hpp"

namespace stylet {

namespace {

constexpr std::size_t dim = 3;

}  // namespace

void predict_in_space(const ExplicitArrays& x,
                      const ExplicitFactors& f,
                      std::span<const GivenPlace> given,
                      StepSums& sums) {
  const double half = 0.5 * f.h;
  for (std::size_t i = 0; i < dim * x.n_nodes; ++i) {
    double now = x.v0[i] + half * x.a0[i];
    double place = x.u0[i] + f.h * now;
    const double m = x.mass[i / dim];
    if (!given.empty() && given.front().dof == i) {
      place = given.front().value;
      const double free = now;
      now = (place - x.u0[i]) / f.h;
      sums.blow += 0.5 * m * (now * now - free * free);
      given = given.subspan(1);
    }
    sums.start += x.v0[i] * m * now;
    sums.half += now * m * now;
    x.v[i] = now;
    x.u[i] = place;
    x.stretched[i] = place + f.stiffness_factor * now;
  }
}

void accelerate_in_space(const ExplicitArrays& x, const ExplicitFactors& f, StepSums& sums) {
  const double half = 0.5 * f.h;
  const double damped = 1 / (1 + half * f.mass_factor);
  for (std::size_t i = 0; i < dim * x.n_nodes; ++i) {
    const double before = x.v[i];
    const double load = x.load != nullptr ? x.load[i] : 0.0;
    const double rest = load - x.force[i];
    const double a = (rest / x.mass[i / dim] - f.mass_factor * before) * damped;
    sums.load += load * before;
    sums.rest += rest * before;
    x.a[i] = a;
    x.v[i] = before + half * a;
  }
}

}  // namespace stylet
