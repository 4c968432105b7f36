// From the near coordinates to all dofs: solves with the factor, and their check.
#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/solvers/near_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stylet {

void NearField::respond(std::span<const double> forces, Vec x) {
  answer(forces, false, x);
}

void NearField::expand(std::span<const double> x_near, Vec x) {
  std::vector<double> difference(x_near.begin(), x_near.end());
  for (std::size_t i = 0; i < size(); ++i) difference[i] -= y_near_[i];
  answer(factored_forces(difference), true, x);
}

// The largest entry but for those of eliminated dofs.
double NearField::largest_free(Vec residual) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double size = 0;
  {
    const Values r(residual);
    PetscInt begin = 0;
    PetscInt end = 0;
    check(VecGetOwnershipRange(residual, &begin, &end));
    const auto up_to = [&](PetscInt to) {
      for (; begin < to; ++begin) {
        const double entry = std::abs(r[begin]);
        if (!(entry <= size)) size = std::isnan(entry) ? infinity : entry;
      }
    };
    for (const int dof : held_here_) {
      up_to(dof);
      ++begin;
    }
    up_to(end);
  }
  if (size_of(comm_) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, &size, 1, MPI_DOUBLE, MPI_MAX, comm_);
  }
  return size;
}

// Iterative refinement: the factor is of an older operator and the dense matrices have been updated
// many times, so what they leave is solved for again.
bool NearField::complete(const Balance& balance,
                         double largest,
                         std::span<const double> extra,
                         const Demand& demand,
                         Solution& solution,
                         Vec x,
                         Vec residual) {
  constexpr double wanted = 1e-10;  // of the largest nodal force
  constexpr double allowed = 1e-8;
  constexpr int most_rounds = 6;
  expand(solution.x, x);
  double scale = largest;
  for (const double force : extra) scale = std::max(scale, std::abs(force));
  for (const double force : solution.reaction) scale = std::max(scale, std::abs(force));
  scale = std::max(scale, std::abs(solution.lambda));
  // Round-off of numbers that underflow is not relative to them.
  constexpr double smallest =
      std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
  if (scale < smallest) scale = 1;
  Demand still = demand;
  for (auto& g : still.given) g.value = 0;
  for (auto& spring : still.springs) spring.force = 0;
  still.value = 0;
  double last = std::numeric_limits<double>::infinity();
  for (int round = 0;; ++round) {
    balance(x, residual);
    {
      Entries r(residual);
      for (std::size_t i = 0; i < size(); ++i) subtract(i, solution.reaction[i], r);
      for (const auto& [at, weight] : demand.weights) subtract(at, solution.lambda * weight, r);
    }
    const double size = largest_free(residual);
    if (size <= wanted * scale) return round > 0;
    if (round == most_rounds || !(size < 0.5 * last)) {
      if (size <= allowed * scale) return round > 0;
      throw NumericalError("the step's forces do not balance: " + exact(size) + " N of " +
                           exact(scale) + " N are left");
    }
    last = size;
    check(VecCopy(residual, correction_.get()));
    check(VecScale(correction_.get(), -1));
    {
      Entries r(correction_.get());
      for (const int dof : held_) {
        if (r.owns(dof)) r[dof] = 0;
      }
    }
    load(correction_.get());
    const std::vector<double> none(coordinates_.size(), 0.0);
    const Solution more = solve(none, still);
    expand(more.x, correction_.get());
    check(VecAXPY(x, 1, correction_.get()));
    solution.lambda += more.lambda;
    for (std::size_t i = 0; i < coordinates_.size(); ++i) {
      solution.x[i] += more.x[i];
      solution.reaction[i] += more.reaction[i];
    }
  }
}

}  // namespace stylet
