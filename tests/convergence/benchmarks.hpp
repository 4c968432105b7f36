// Benchmarks with known answers (plane strain, E = 1, high-order computations) on any mesh: Cook's
// membrane, a rigid line in a square stuck (B) or sliding (C), natural frequencies of a clamped square.
#pragma once

#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/dynamics/modes.hpp"
#include "stylet/mesh/embedded_point.hpp"

#include "support/body.hpp"

#include <string>
#include <vector>

namespace stylet::benchmark {

/// Sides left, right, bottom, top and the curve `line`, y = 1/2 from x = 1/2 to 1.
inline MeshData square(int n, Diagonals diagonals) {
  RectangleMesh p;
  p.width = p.height = 1;
  p.columns = p.rows = n;
  p.diagonals = diagonals;
  p.curves = {{"line", {{0.5, 0.5}, {1, 0.5}}}};
  return make_rectangle(p);
}

/// Corners (0,0), (48,44), (48,60), (0,44).
inline MeshData cook(int n, Diagonals diagonals) {
  MeshData data = rectangle({.columns = n, .rows = n, .diagonals = diagonals});
  for (std::size_t i = 0; i < data.coordinates.size(); i += 2) {
    const double x = data.coordinates[i];
    const double y = data.coordinates[i + 1];
    data.coordinates[i] = 48 * x;
    data.coordinates[i + 1] = 44 * x + y * (44 - 28 * x);
  }
  return data;
}

struct Problem {
  Problem(MeshData data, double nu, Formulation formulation)
      : body(std::move(data),
             material({1, nu, 1}, Plane::strain, MassKind::consistent, 1, formulation)) {}

  /// A total force, spread evenly over a curve.
  void pull(const std::string& curve, Vector2 total) {
    force.assign(static_cast<std::size_t>(body.tissue.n_dofs()), 0.0);
    double length = 0;
    for (const int round : {0, 1}) {
      for (const int f : body.mesh.facets_of(curve)) {
        const auto* ends = &body.mesh.data().facets[2 * static_cast<std::size_t>(f)];
        const double piece = distance(body.mesh.point(ends[0]), body.mesh.point(ends[1]));
        if (round == 0) length += piece;
        for (std::size_t e = 0; round == 1 && e < 2; ++e) {
          const auto dof = 2 * static_cast<std::size_t>(ends[e]);
          force[dof] += 0.5 * piece / length * total.x;
          force[dof + 1] += 0.5 * piece / length * total.y;
        }
      }
    }
  }

  void solve(const ConstraintSet& constraints) {
    OwnedVec load = body.tissue.make_vector();
    check(VecSet(load.get(), 0));
    if (!force.empty()) load = vector_of(body.tissue, force);
    TimeParameters time;
    time.method = TimeMethod::quasi_static;
    ImplicitNewmark integrator(body.tissue, time);
    State state = still(body.tissue);
    step(integrator, state, load.get(), 1, constraints);
    u = gather_all(state.u.get());
    reaction = product(body.tissue, body.tissue.stiffness(), state.u.get());
  }

  [[nodiscard]] Vector2 displacement(ReferencePoint x) const {
    const auto at = *locate(body.mesh, x);
    Vector2 sum;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto dof = 2 * static_cast<std::size_t>(body.mesh.cell(at.cell)[k]);
      sum = sum + at.weights[k] * Vector2{u[dof], u[dof + 1]};
    }
    return sum;
  }

  Slab body;
  std::vector<double> force;
  std::vector<double> u;
  std::vector<double> reaction;  ///< K u
};

struct CookAnswer {
  double middle;  ///< vertical displacement at (48, 52)
  double corner;  ///< at (48, 60)
};

inline CookAnswer cook_displacements(MeshData mesh, double nu, Formulation formulation) {
  Problem problem(std::move(mesh), nu, formulation);
  problem.pull("right", {0, 1});
  problem.solve(held(dofs_of(problem.body.mesh, {"left"})));
  return {problem.displacement({48, 52}).y, problem.displacement({48, 60}).y};
}

/// Constraints of B and C: the line's across dof held, its along dof moved or free.
inline ConstraintSet line_constraints(const Mesh& mesh, bool stuck) {
  const auto sides = dofs_of(mesh, {"left", "top", "bottom"});
  ConstraintSet set = held(sides);
  for (const int node : mesh.nodes_of("line")) {
    if (std::ranges::binary_search(sides, 2 * node)) continue;
    if (stuck) set.dofs.push_back({2 * node, -1.0});
    set.dofs.push_back({2 * node + 1, 0.0});
  }
  return set;
}

/// B: the axial force of the line moved by (-1, 0).
inline double stuck_force(MeshData mesh, double nu, Formulation formulation) {
  Problem problem(std::move(mesh), nu, formulation);
  problem.solve(line_constraints(problem.body.mesh, true));
  double sum = 0;
  for (const int node : problem.body.mesh.nodes_of("line")) {
    sum -= problem.reaction[2 * static_cast<std::size_t>(node)];
  }
  return sum;
}

/// C: displacement of the line's inner end under a total axial force of -1.
inline double sliding_displacement(MeshData mesh, double nu, Formulation formulation) {
  Problem problem(std::move(mesh), nu, formulation);
  problem.pull("line", {-1, 0});
  problem.solve(line_constraints(problem.body.mesh, false));
  return problem.displacement({0.5, 0.5}).x;
}

/// The three lowest with left, top and bottom held.
inline std::vector<double> clamped_frequencies(MeshData mesh, double nu, Formulation formulation) {
  const Problem problem(std::move(mesh), nu, formulation);
  return natural_frequencies(problem.body.tissue,
                             dofs_of(problem.body.mesh, {"left", "top", "bottom"}), 3);
}

}  // namespace stylet::benchmark
