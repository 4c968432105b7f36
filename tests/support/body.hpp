// A piece of tissue on one rank for tests that talk to mesh, operator and integrators themselves.
#pragma once

#include "stylet/dynamics/time_integrator.hpp"
#include "stylet/fem/tissue_operator.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/quadratic.hpp"
#include "stylet/mesh/rectangle.hpp"
#include "stylet/mesh/validate.hpp"
#include "stylet/petsc/check.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace stylet {

struct Grid {
  double width = 1;
  double height = 1;
  int columns = 1;
  int rows = 1;
  double jitter = 0;
  Diagonals diagonals = Diagonals::alternating;
};

/// Sides left, right, bottom, top; region tissue.
inline MeshData rectangle(const Grid& grid) {
  RectangleMesh p;
  p.width = grid.width;
  p.height = grid.height;
  p.columns = grid.columns;
  p.rows = grid.rows;
  p.jitter = grid.jitter;
  p.diagonals = grid.diagonals;
  return make_rectangle(p);
}

/// One material in region tissue.
inline TissueParameters material(const LinearElastic& elastic,
                                 Plane plane,
                                 MassKind mass = MassKind::consistent,
                                 double thickness = 1,
                                 Formulation formulation = Formulation::p1) {
  TissueParameters p;
  p.plane = plane;
  p.formulation = formulation;
  p.thickness = thickness;
  p.mass = mass;
  p.regions = {{"tissue", elastic}};
  return p;
}

/// Nodes have the numbers of the data.
struct Slab {
  Slab(MeshData data, const TissueParameters& parameters, std::function<bool(int)> needs_flips = {})
      : mesh(checked(std::move(data), parameters.formulation)),
        tissue(MPI_COMM_WORLD, mesh, {0, mesh.n_nodes()}, parameters, std::move(needs_flips)) {}

  static MeshData checked(MeshData data, Formulation formulation) {
    validate(data);
    if (formulation == Formulation::p2) add_mid_edge_nodes(data);
    return data;
  }

  Mesh mesh;
  TissueOperator tissue;
};

/// field: ReferencePoint -> Vector2.
template <class Field>
OwnedVec nodal(const TissueOperator& tissue, const Mesh& mesh, Field&& field) {
  OwnedVec vec = tissue.make_vector();
  PetscScalar* values = nullptr;
  check(VecGetArray(vec.get(), &values));
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const Vector2 value = field(mesh.point(node));
    values[2 * node] = value.x;
    values[2 * node + 1] = value.y;
  }
  check(VecRestoreArray(vec.get(), &values));
  return vec;
}

inline OwnedVec vector_of(const TissueOperator& tissue, std::span<const double> from) {
  OwnedVec vec = tissue.make_vector();
  PetscScalar* values = nullptr;
  check(VecGetArray(vec.get(), &values));
  std::ranges::copy(from, values);
  check(VecRestoreArray(vec.get(), &values));
  return vec;
}

inline std::vector<double> product(const TissueOperator& tissue, Mat matrix, Vec x) {
  OwnedVec y = tissue.make_vector();
  check(MatMult(matrix, x, y.get()));
  return gather_all(y.get());
}

/// K u, of explicit runs too.
inline std::vector<double> stiffness_forces(const TissueOperator& tissue, Vec u) {
  OwnedVec forces = tissue.make_vector();
  tissue.apply_stiffness(u, forces.get());
  return gather_all(forces.get());
}

inline double largest(std::span<const double> values) {
  double size = 0;
  for (const double value : values) size = std::max(size, std::abs(value));
  return size;
}

/// Both dofs of the nodes of the curves; ascending.
inline std::vector<int> dofs_of(const Mesh& mesh, const std::vector<std::string>& curves) {
  std::vector<int> dofs;
  for (const auto& curve : curves) {
    for (const int node : mesh.nodes_of(curve)) {
      dofs.push_back(2 * node);
      dofs.push_back(2 * node + 1);
    }
  }
  std::ranges::sort(dofs);
  dofs.erase(std::ranges::unique(dofs).begin(), dofs.end());
  return dofs;
}

/// The dofs that are not among the given ones; ascending.
inline std::vector<int> others(const TissueOperator& tissue, std::span<const int> dofs) {
  std::vector<int> rest;
  for (int dof = 0; dof < tissue.n_dofs(); ++dof) {
    if (std::ranges::find(dofs, dof) == dofs.end()) rest.push_back(dof);
  }
  return rest;
}

inline ConstraintSet held(std::span<const int> dofs) {
  ConstraintSet set;
  for (const int dof : dofs) set.dofs.push_back({dof, 0.0});
  return set;
}

inline State still(const TissueOperator& tissue) {
  State state{0, tissue.make_vector(), tissue.make_vector(), tissue.make_vector()};
  for (const Vec vec : {state.u.get(), state.v.get(), state.a.get()}) check(VecSet(vec, 0));
  return state;
}

/// Order from errors at two resolutions, the finer one `ratio` times as fine.
inline double order(double coarse, double fine, double ratio = 2) {
  return std::log(coarse / fine) / std::log(ratio);
}

}  // namespace stylet
