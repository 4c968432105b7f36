// One explicit step on one rank in two passes over the nodes, where PETSc's vector operations would
// take nine. Plain arrays; dofs in pairs, dof = 2 node + component.
#pragma once

#include <petscsys.h>

#include <cstddef>

namespace stylet {

/// K by rows of dofs (compressed sparse rows): the two rows of a node have the same columns, which
/// come in pairs.
struct RowMatrix {
  const PetscInt* first;
  const PetscInt* columns;
  const PetscScalar* values;
};

struct ExplicitArrays {
  std::size_t n_dofs;
  const double* u0;  ///< start of the step
  const double* v0;
  const double* a0;
  double* u;  ///< end of the step
  double* v;  ///< after `predict` the velocity of the half step
  double* a;
  double* stretched;  ///< u + stiffness_factor v of the half step
  const double* load;
  const double* mass;
};

/// v = v0 + h/2 a0, u = u0 + h v, stretched = u + stiffness_factor v.
void predict(const ExplicitArrays& x, double h, double stiffness_factor);

/// force = K stretched:
/// a = ((load - force)/mass - mass_factor v) / (1 + h/2 mass_factor), v = v + h/2 a.
void accelerate(const ExplicitArrays& x, const RowMatrix& k, double h, double mass_factor);
/// The same where the force is known.
void accelerate(const ExplicitArrays& x, const double* force, double h, double mass_factor);

}  // namespace stylet
