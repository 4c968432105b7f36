#include "stylet/dynamics/implicit_newmark.hpp"

#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"

#include <limits>
#include <vector>

namespace stylet {

StepCoefficients coefficients(ImplicitScheme scheme, double rho_infinity) {
  switch (scheme) {
    case ImplicitScheme::average_acceleration:
      return {0, 0.25, 0.25, 0.5, 0.5};
    case ImplicitScheme::backward_euler:
      return {0, 0, 1, 0, 1};
    case ImplicitScheme::generalised_alpha:
      break;
  }
  const double alpha_m = (rho_infinity - 1) / (rho_infinity + 1);
  const double gamma = 0.5 - alpha_m;
  const double beta = 0.25 * (1 - alpha_m) * (1 - alpha_m);
  return {alpha_m, 0.5 - beta, beta, 1 - gamma, gamma};
}

ImplicitNewmark::ImplicitNewmark(TissueOperator& tissue, const TimeParameters& parameters)
    : tissue_(tissue),
      inertia_(parameters.method != TimeMethod::quasi_static),
      k_(coefficients(parameters.scheme, parameters.rho_infinity)),
      solver_(tissue.comm()) {
  if (!inertia_) k_ = {0, 0, 1, 0, 1};
  for (OwnedVec* vec :
       {&u_, &v_, &u_guess_, &v_guess_, &increment_, &rhs_, &rhs_base_, &reaction_, &work_}) {
    *vec = tissue.make_vector();
    check(VecSet(vec->get(), 0));
  }
}

double ImplicitNewmark::stable_step() const {
  return std::numeric_limits<double>::infinity();
}

void ImplicitNewmark::begin(State& state, Vec load, double h) {
  state_ = &state;
  load_ = load;
  h_ = h;
  if (!inertia_ && operator_h_ == 0) {
    tissue_.make_tangent({0, 1});
    solver_.forget();
  } else if (inertia_ && h != operator_h_) {
    tissue_.make_tangent(tissue_.tangent(k_.g1 / (k_.c1 * h), (1 - k_.alpha_m) / (k_.c1 * h * h)));
    solver_.forget();
  }
  operator_h_ = h;
  predict();
}

// Predictors from the state as it is now, and the forces that they leave unbalanced.
void ImplicitNewmark::predict() {
  const Vec u0 = state_->u.get();
  const Vec v0 = state_->v.get();
  const Vec a0 = state_->a.get();
  check(VecCopy(u0, u_guess_.get()));
  if (!inertia_) {
    check(VecSet(v_guess_.get(), 0));
    check(MatMult(tissue_.stiffness(), u_guess_.get(), work_.get()));
    check(VecWAXPY(rhs_base_.get(), -1, work_.get(), load_));
    return;
  }
  check(VecAXPY(u_guess_.get(), h_, v0));
  check(VecAXPY(u_guess_.get(), h_ * h_ * k_.c0, a0));
  check(VecWAXPY(v_guess_.get(), h_ * k_.g0, a0, v0));
  const auto damping = tissue_.damping().value_or(RayleighDamping{});
  // K (u + stiffness_factor v)
  check(VecWAXPY(work_.get(), damping.stiffness_factor, v_guess_.get(), u_guess_.get()));
  check(MatMult(tissue_.stiffness(), work_.get(), rhs_base_.get()));
  // M (alpha_m a0 + mass_factor v)
  if (k_.alpha_m != 0 || damping.mass_factor != 0) {
    check(VecCopy(a0, work_.get()));
    check(VecScale(work_.get(), k_.alpha_m));
    check(VecAXPY(work_.get(), damping.mass_factor, v_guess_.get()));
    tissue_.apply_mass(work_.get(), reaction_.get());
    check(VecAXPY(rhs_base_.get(), 1, reaction_.get()));
  }
  check(VecAYPX(rhs_base_.get(), -1, load_));
}

Trial ImplicitNewmark::attempt(const ConstraintSet& constraints, bool edited) {
  if (edited) predict();
  check(VecCopy(rhs_base_.get(), rhs_.get()));
  PetscInt begin = 0;
  PetscInt end = 0;
  check(VecGetOwnershipRange(rhs_.get(), &begin, &end));
  PetscScalar* b = nullptr;
  check(VecGetArray(rhs_.get(), &b));
  for (const auto& [dof, force] : constraints.forces) {
    if (dof >= begin && dof < end) b[dof - begin] += force;
  }
  check(VecRestoreArray(rhs_.get(), &b));

  // Given displacements and velocities as given increments.
  const PetscScalar* u = nullptr;
  const PetscScalar* v = nullptr;
  check(VecGetArrayRead(u_guess_.get(), &u));
  check(VecGetArrayRead(v_guess_.get(), &v));
  const double speed = k_.g1 / (k_.c1 * h_);  // v1 = v_guess + speed * increment
  std::vector<DofValue> given;
  given.reserve(constraints.dofs.size());
  for (const auto& c : constraints.dofs) {
    double value = 0;
    if (c.dof >= begin && c.dof < end) {
      value = c.velocity ? (c.value - v[c.dof - begin]) / speed : c.value - u[c.dof - begin];
    }
    given.push_back({c.dof, value});
  }
  std::optional<MeanCondition> mean = constraints.mean;
  if (mean) {
    double before = 0;
    for (const auto& [dof, weight] : mean->weights) {
      if (dof >= begin && dof < end) before += weight * u[dof - begin];
    }
    if (size_of(tissue_.comm()) > 1) {
      check_mpi(MPI_Allreduce(MPI_IN_PLACE, &before, 1, MPI_DOUBLE, MPI_SUM, tissue_.comm()));
    }
    mean->value -= before;
  }
  check(VecRestoreArrayRead(v_guess_.get(), &v));
  check(VecRestoreArrayRead(u_guess_.get(), &u));

  const auto result = solver_.solve(tissue_.tangent_matrix(), rhs_.get(), given,
                                    mean ? &*mean : nullptr, increment_.get(), reaction_.get());
  check(VecWAXPY(u_.get(), 1, increment_.get(), u_guess_.get()));
  check(VecWAXPY(v_.get(), speed, increment_.get(), v_guess_.get()));
  return {u_.get(), v_.get(), reaction_.get(), result.lambda, result.iterations};
}

void ImplicitNewmark::accept() {
  check(VecCopy(u_.get(), state_->u.get()));
  check(VecCopy(v_.get(), state_->v.get()));
  if (inertia_) {
    check(VecCopy(increment_.get(), state_->a.get()));
    check(VecScale(state_->a.get(), 1 / (k_.c1 * h_ * h_)));
  }
  state_->t += h_;
}

void initial_acceleration(const TissueOperator& tissue,
                          State& state,
                          Vec load,
                          const ConstraintSet& constraints) {
  OwnedVec rhs = tissue.make_vector();
  OwnedVec work = tissue.make_vector();
  const auto damping = tissue.damping().value_or(RayleighDamping{});
  check(VecWAXPY(work.get(), damping.stiffness_factor, state.v.get(), state.u.get()));
  check(MatMult(tissue.stiffness(), work.get(), rhs.get()));
  tissue.apply_mass(state.v.get(), work.get());
  check(VecAXPY(rhs.get(), damping.mass_factor, work.get()));
  check(VecAYPX(rhs.get(), -1, load));
  PetscReal size = 0;
  check(VecNorm(rhs.get(), NORM_INFINITY, &size));
  check(VecSet(state.a.get(), 0));
  if (size == 0) return;
  std::vector<DofValue> given;
  for (const auto& c : constraints.dofs) given.push_back({c.dof, 0.0});
  if (tissue.mass() != nullptr) {
    ConstrainedSolver solver(tissue.comm());
    solver.solve(tissue.mass(), rhs.get(), given, nullptr, state.a.get(), work.get());
    return;
  }
  check(VecPointwiseDivide(state.a.get(), rhs.get(), tissue.lumped_mass()));
  for (const auto& [dof, zero] : given) set_owned(state.a.get(), dof, zero);
}

}  // namespace stylet
