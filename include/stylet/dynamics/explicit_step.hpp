// One explicit step on plain arrays of a rank's nodes; dof = dim local node + component.
//
// On one rank it is one pass over the mesh. Nodes are numbered so that triangles join near ones; block
// by block of them, they are predicted just before the first triangle that reads them and get their
// acceleration just after the last one that pushes them, so that what a block needs comes from memory
// once (the wavefront of stencil codes). On several ranks the prediction comes first, since ghosts have
// to be sent.
#pragma once

#include "stylet/fem/cell_kernel.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace stylet {

struct ExplicitArrays {
  std::size_t n_nodes;  ///< owned
  const double* u0;     ///< start of the step
  const double* v0;
  const double* a0;
  double* u;  ///< end of the step
  double* v;  ///< after `predict` the velocity of the half step
  double* a;
  /// u + stiffness_factor v of the half step; may be u where that is 0. With ghosts.
  double* stretched;
  double* force;               ///< K stretched, with ghosts; may be a if there are none
  const double* load;          ///< null if there is none
  const double* mass;          ///< one a node
  const double* inverse_root;  ///< 1 / sqrt(mass)
};

/// A dof that is at `value` at the end of the step.
struct GivenPlace {
  std::size_t dof;
  double value;
};

/// How far a step goes and what damps it.
struct ExplicitFactors {
  double h;
  double mass_factor;
  double stiffness_factor;
};

/// Sums over nodes; v is the velocity of the half step.
struct StepSums {
  double start = 0;  ///< v0 M v
  double half = 0;   ///< v M v
  double blow = 0;   ///< energy that given places bring in
  double load = 0;   ///< v load
  double rest = 0;   ///< v (load - force)
};

/// v = v0 + h/2 a0, u = u0 + h v, stretched = u + stiffness_factor v. given: ascending.
void predict(const ExplicitArrays& x,
             const ExplicitFactors& f,
             std::span<const GivenPlace> given,
             StepSums& sums);
/// force = K stretched, a = ((load - force)/mass - mass_factor v) / (1 + h/2 mass_factor),
/// v = v + h/2 a. pressure: room for the kernel's patches.
void accelerate(const ExplicitArrays& x,
                const ExplicitFactors& f,
                const CellKernel& cells,
                std::vector<double>& pressure,
                StepSums& sums);
/// The same in space, where `force` is K stretched already; it may be a.
void predict_in_space(const ExplicitArrays& x,
                      const ExplicitFactors& f,
                      std::span<const GivenPlace> given,
                      StepSums& sums);
void accelerate_in_space(const ExplicitArrays& x, const ExplicitFactors& f, StepSums& sums);
/// Both in one pass, on one rank, in the plane.
void step(const ExplicitArrays& x,
          const ExplicitFactors& f,
          const CellKernel& cells,
          std::span<const GivenPlace> given,
          std::vector<double>& pressure,
          StepSums& sums);

}  // namespace stylet
