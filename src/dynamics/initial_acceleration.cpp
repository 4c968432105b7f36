#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/solvers/mass_solver.hpp"

#include <vector>

namespace stylet {

void initial_acceleration(const TissueOperator& tissue,
                          State& state,
                          Vec load,
                          const ConstraintSet& constraints) {
  OwnedVec rhs = tissue.make_vector();
  OwnedVec work = tissue.make_vector();
  const auto damping = tissue.damping().value_or(RayleighDamping{});
  check(VecWAXPY(work.get(), damping.stiffness_factor, state.v.get(), state.u.get()));
  tissue.apply_stiffness(work.get(), rhs.get());
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
    MassSolver solver(tissue.comm());
    solver.solve(tissue.mass(), rhs.get(), given, nullptr, state.a.get(), work.get());
    return;
  }
  check(VecPointwiseDivide(state.a.get(), rhs.get(), tissue.lumped_mass()));
  for (const auto& [dof, zero] : given) set_owned(state.a.get(), dof, zero);
}

}  // namespace stylet
