// A piece of tissue in space on one rank, for tests that talk to mesh, operator and integrators
// themselves.
#pragma once

#include "stylet/dynamics/quasi_static.hpp"
#include "stylet/mesh/box.hpp"
#include "stylet/mesh/embedded_point.hpp"

#include "support/body.hpp"

#include <array>
#include <string>

namespace stylet {

/// Bricks of about the same length along all axes on [0, width] x [0, height] x [0, depth].
inline MeshData bricks(std::array<double, 3> size, std::array<int, 3> n, double jitter = 0) {
  BoxMesh p;
  p.width = size[0];
  p.height = size[1];
  p.depth = size[2];
  p.columns = n[0];
  p.rows = n[1];
  p.layers = n[2];
  p.jitter = jitter;
  return make_box(p);
}

inline TissueParameters solid(const LinearElastic& elastic,
                              Formulation formulation,
                              MassKind mass = MassKind::consistent) {
  TissueParameters p;
  p.plane.reset();
  p.formulation = formulation;
  p.mass = mass;
  p.regions = {{"tissue", elastic}};
  return p;
}

/// field: ReferencePlace -> Vector3.
template <class Field>
OwnedVec nodal_in_space(const TissueOperator& tissue, const Mesh& mesh, Field&& field) {
  std::vector<double> values;
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const Vector3 u = field(mesh.place(node));
    values.insert(values.end(), {u.x, u.y, u.z});
  }
  return vector_of(tissue, values);
}

/// Dofs of these components (such as "xz") of the nodes of a surface; ascending.
inline std::vector<int> dofs_on(const Mesh& mesh,
                                const std::string& surface,
                                const std::string& axes = "xyz") {
  std::vector<int> dofs;
  for (const int node : mesh.nodes_of(surface)) {
    for (int k = 0; k < 3; ++k) {
      if (axes.find("xyz"[k]) != std::string::npos) dofs.push_back(3 * node + k);
    }
  }
  return dofs;
}

/// Of the node at a place.
inline Vector3 value_at(const Mesh& mesh, std::span<const double> u, ReferencePlace x) {
  Vector3 sum;
  for (const auto& [node, weight] : node_weights(mesh, *locate(mesh, x))) {
    const double* of_node = &u[3 * static_cast<std::size_t>(node)];
    sum = sum + weight * Vector3{of_node[0], of_node[1], of_node[2]};
  }
  return sum;
}

/// Nodal forces of a uniform traction (Pa) on a surface.
inline std::vector<double> traction_on(const Mesh& mesh, const std::string& surface, Vector3 t) {
  std::vector<double> force(3 * static_cast<std::size_t>(mesh.n_nodes()), 0.0);
  for (const int f : mesh.facets_of(surface)) {
    const double share = mesh.facet_measure(f) / 3;
    const auto nodes = mesh.facet_nodes(f);
    for (const int node : mesh.is_quadratic() ? nodes.subspan(3) : nodes) {
      double* of_node = &force[3 * static_cast<std::size_t>(node)];
      of_node[0] += share * t.x;
      of_node[1] += share * t.y;
      of_node[2] += share * t.z;
    }
  }
  return force;
}

/// Displacements at rest under these forces.
inline std::vector<double> at_rest(Slab& body,
                                   std::span<const double> force,
                                   const ConstraintSet& constraints) {
  const OwnedVec load = vector_of(body.tissue, force);
  QuasiStatic integrator(body.tissue, body.mesh);
  State state = still(body.tissue);
  integrator.begin(state, load.get(), 1, constraints.dofs);
  integrator.attempt({}, false);
  const Trial trial = integrator.finish(true);
  return gather_all(trial.u);
}

}  // namespace stylet
