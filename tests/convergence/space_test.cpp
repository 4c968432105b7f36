// Known answers in space and the order in which tetrahedra reach them: a manufactured displacement, modes
// of a box, bending, Cook's membrane between rollers.
#include "stylet/fem/material.hpp"
#include "stylet/fem/simplex.hpp"
#include "stylet/mesh/refine.hpp"
#include "stylet/solvers/modes.hpp"

#include "support/solid.hpp"
#include <gtest/gtest.h>

#include <numbers>

namespace stylet {
namespace {

constexpr double pi = std::numbers::pi;

// The points of a rule for quadratics on each of the eight parts of a tetrahedron.
std::vector<std::array<double, 4>> fine_points() {
  MeshData unit;
  unit.dim = 3;
  unit.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  unit.cells = {0, 1, 2, 3};
  unit.cell_region = {0};
  unit.region_names = {"tissue"};
  const Mesh parts(refine(unit, 1));
  std::vector<std::array<double, 4>> points;
  for (int c = 0; c < parts.n_cells(); ++c) {
    for (const auto& l : tetrahedron_points()) {
      const auto t = parts.tetrahedron(c);
      Vector3 x;
      for (std::size_t k = 0; k < 4; ++k) x = x + l[k] * (t[k] - ReferencePlace{});
      points.push_back({1 - x.x - x.y - x.z, x.x, x.y, x.z});
    }
  }
  return points;
}

// Calls each(point, weight).
template <class Each>
void each_point(const Mesh& mesh, int c, Each&& each) {
  static const auto fine = fine_points();
  const double share = mesh.cell_measure(c) / static_cast<double>(fine.size());
  const auto t = mesh.tetrahedron(c);
  for (const auto& l : fine) {
    EmbeddedPoint point{{}, c, l};
    for (std::size_t k = 0; k < 4; ++k) point.x = point.x + l[k] * (t[k] - ReferencePlace{});
    each(point, share);
  }
}

struct Errors {
  double displacement;  ///< in L2
  double energy;        ///< its root
};

// u = a sin(pi x) sin(pi y) sin(pi z) on the unit cube, which is held on all sides.
constexpr Vector3 amplitude{1, -0.7, 0.4};

Errors manufactured_errors(MeshData data, double nu, Formulation formulation) {
  const LinearElastic elastic{1, nu, 1};
  Slab body(std::move(data), solid(elastic, formulation));
  const Moduli m = lame_moduli(elastic);
  const auto exact = [](ReferencePlace x) {
    return std::sin(pi * x.x) * std::sin(pi * x.y) * std::sin(pi * x.z) * amplitude;
  };
  // -div sigma = (lambda + mu) grad(...) + mu 3 pi^2 u
  const auto body_force = [&](ReferencePlace x) {
    const Vector3 s{std::sin(pi * x.x), std::sin(pi * x.y), std::sin(pi * x.z)};
    const Vector3 c{std::cos(pi * x.x), std::cos(pi * x.y), std::cos(pi * x.z)};
    const Vector3 a = amplitude;
    const double same = s.x * s.y * s.z;
    const Vector3 gradient{-a.x * same + a.y * c.x * c.y * s.z + a.z * c.x * s.y * c.z,
                           a.x * c.x * c.y * s.z - a.y * same + a.z * s.x * c.y * c.z,
                           a.x * c.x * s.y * c.z + a.y * s.x * c.y * c.z - a.z * same};
    return pi * pi * ((-(m.lambda + m.mu)) * gradient + (3 * m.mu * same) * a);
  };
  std::vector<double> force(static_cast<std::size_t>(body.tissue.n_dofs()), 0.0);
  for (int c = 0; c < body.mesh.n_cells(); ++c) {
    each_point(body.mesh, c, [&](const EmbeddedPoint& point, double weight) {
      const Vector3 f = body_force(point.x);
      for (const auto& [node, value] : node_weights(body.mesh, point)) {
        double* of_node = &force[3 * static_cast<std::size_t>(node)];
        for (std::size_t i = 0; i < 3; ++i)
          of_node[i] += weight * value * std::array{f.x, f.y, f.z}[i];
      }
    });
  }
  std::vector<int> sides;
  for (int node = 0; node < body.mesh.n_nodes(); ++node) {
    if (!body.mesh.on_boundary(node)) continue;
    for (int k = 0; k < 3; ++k) sides.push_back(3 * node + k);
  }
  const auto u = at_rest(body, force, held(sides));
  Errors squares{0, 0};
  for (int c = 0; c < body.mesh.n_cells(); ++c) {
    each_point(body.mesh, c, [&](const EmbeddedPoint& point, double weight) {
      Vector3 miss = -exact(point.x);
      for (const auto& [node, value] : node_weights(body.mesh, point)) {
        const double* of_node = &u[3 * static_cast<std::size_t>(node)];
        miss = miss + value * Vector3{of_node[0], of_node[1], of_node[2]};
      }
      squares.displacement += weight * dot(miss, miss);
      auto h = gradient_at(body.mesh, c, point.weights, u);
      const double x[3] = {pi * point.x.x, pi * point.x.y, pi * point.x.z};
      for (std::size_t k = 0; k < 3; ++k) {
        const double slope =
            pi * std::cos(x[k]) * std::sin(x[(k + 1) % 3]) * std::sin(x[(k + 2) % 3]);
        for (std::size_t i = 0; i < 3; ++i)
          h[i][k] -= slope * std::array{amplitude.x, amplitude.y, amplitude.z}[i];
      }
      const double trace = h[0][0] + h[1][1] + h[2][2];
      squares.energy += weight * (shear_energy_density(h, m.mu) + 0.5 * m.lambda * trace * trace);
    });
  }
  return {std::sqrt(squares.displacement), std::sqrt(squares.energy)};
}

double manufactured_error(int n, double nu, Formulation formulation) {
  return manufactured_errors(bricks({1, 1, 1}, {n, n, n}, 0.1), nu, formulation).displacement;
}

TEST(Space, ManufacturedDisplacementConvergesWithOrderTwo) {
  for (const Formulation formulation : {Formulation::p1, Formulation::p1_averaged}) {
    for (const double nu : {0.3, 0.49}) {
      if (formulation == Formulation::p1 && nu > 0.4) continue;  // locks
      const double coarse = manufactured_error(5, nu, formulation);
      const double fine = manufactured_error(10, nu, formulation);
      const double seen = order(coarse, fine);
      EXPECT_GT(seen, 1.7) << nu << " " << coarse << " " << fine;
      EXPECT_LT(seen, 2.4) << nu;
      RecordProperty("order", std::to_string(seen));
    }
  }
}

// On nested meshes.
TEST(Space, QuadraticTetrahedraConvergeWithOrderThreeAndTwoInEnergy) {
  for (const double nu : {0.3, 0.49}) {
    const auto errors = [&](int refinements) {
      return manufactured_errors(refine(bricks({1, 1, 1}, {3, 3, 3}, 0.1), refinements), nu,
                                 Formulation::p2);
    };
    const Errors coarse = errors(1);
    const Errors fine = errors(2);
    const double displacement = order(coarse.displacement, fine.displacement);
    const double energy = order(coarse.energy, fine.energy);
    EXPECT_NEAR(displacement, 3, 0.3) << nu << " " << coarse.displacement;
    EXPECT_NEAR(energy, 2, 0.2) << nu << " " << coarse.energy;
    RecordProperty("orders at nu " + std::to_string(nu),
                   std::to_string(displacement) + " " + std::to_string(energy));
  }
}

// Rollers on all sides: c_p k and c_s k with k^2 = (i pi / a)^2 + (j pi / b)^2 + (l pi / c)^2. The lowest
// three are shear waves along two axes.
TEST(Space, ModesOfARolledBoxAreKnown) {
  const std::array<double, 3> size{1, 0.9, 0.8};
  const LinearElastic elastic{1, 0.3, 1};
  const double c_s = std::sqrt(lame_moduli(elastic).mu);
  const auto exact = [&](std::size_t i, std::size_t k) {
    return c_s * pi * std::hypot(1 / size[i], 1 / size[k]);
  };
  const double known[3] = {exact(0, 1), exact(0, 2), exact(1, 2)};
  const auto frequencies = [&](int n, Formulation formulation, MassKind mass) {
    const Slab body(bricks(size, {n, n, n}), solid(elastic, formulation, mass));
    std::vector<int> rollers;
    const std::pair<const char*, const char*> sides[] = {{"left", "x"},   {"right", "x"},
                                                         {"bottom", "y"}, {"top", "y"},
                                                         {"back", "z"},   {"front", "z"}};
    for (const auto& [side, axis] : sides) {
      const auto dofs = dofs_on(body.mesh, side, axis);
      rollers.insert(rollers.end(), dofs.begin(), dofs.end());
    }
    std::ranges::sort(rollers);
    return natural_frequencies(body.tissue, rollers, 3);
  };
  for (const Formulation formulation : {Formulation::p1, Formulation::p1_averaged}) {
    const auto coarse = frequencies(4, formulation, MassKind::consistent);
    const auto fine = frequencies(8, formulation, MassKind::consistent);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_GT(fine[i], known[i]);  // a Ritz value is no lower than the frequency
      EXPECT_NEAR(order(coarse[i] - known[i], fine[i] - known[i]), 2, 0.2);
      EXPECT_NEAR(fine[i], known[i], 0.03 * known[i]);
    }
  }
  const auto coarse = frequencies(4, Formulation::p2, MassKind::consistent);
  const auto fine = frequencies(8, Formulation::p2, MassKind::consistent);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GT(fine[i], known[i]);
    EXPECT_NEAR(order(coarse[i] - known[i], fine[i] - known[i]), 4, 0.3);
    EXPECT_NEAR(fine[i], known[i], 1e-3 * known[i]);
  }
  const auto quadratic_lumped = frequencies(4, Formulation::p2, MassKind::lumped);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(quadratic_lumped[i], known[i], 0.03 * known[i]);
  const auto lumped = frequencies(8, Formulation::p1, MassKind::lumped);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(lumped[i], known[i], 0.03 * known[i]);
}

// A beam bent by moments: sigma_xx = -E kappa y, u_y = kappa/2 (x^2 + nu (y^2 - z^2)), the half of it with
// z > 0. The traction on its end is linear in y.
double tip_deflection(int n, Formulation formulation) {
  const LinearElastic elastic{1, 0.3, 1};
  MeshData data = bricks({4, 1, 0.5}, {8 * n, 2 * n, n});
  for (std::size_t i = 1; i < data.coordinates.size(); i += 3) data.coordinates[i] -= 0.5;
  Slab body(std::move(data), solid(elastic, formulation));
  std::vector<double> force(static_cast<std::size_t>(body.tissue.n_dofs()), 0.0);
  for (const int f : body.mesh.facets_of("right")) {
    const auto nodes = body.mesh.facet(f);
    if (body.mesh.is_quadratic()) {
      const double size = body.mesh.facet_measure(f);
      const auto all = body.mesh.facet_nodes(f);
      const auto y = [&](std::size_t k) { return body.mesh.place(all[k]).y; };
      for (std::size_t k = 0; k < 3; ++k) {
        // int N y of the corner k, and of the middle of the edge from it to the next one
        const double next = y((k + 1) % 3);
        const double last = y((k + 2) % 3);
        const int middle = all[k == 0 ? 3 : k == 1 ? 4 : 5];
        force[3 * static_cast<std::size_t>(all[k])] -= size * (2 * y(k) - next - last) / 60;
        force[3 * static_cast<std::size_t>(middle)] -= size * (2 * y(k) + 2 * next + last) / 15;
      }
      continue;
    }
    for (const int node : nodes) {
      // int N_a y over a triangle: area / 12 (sum of y + y_a)
      double sum = body.mesh.place(node).y;
      for (const int other : nodes) sum += body.mesh.place(other).y;
      force[3 * static_cast<std::size_t>(node)] -= body.mesh.facet_measure(f) / 12 * sum;
    }
  }
  auto fixed = dofs_on(body.mesh, "left", "x");
  const auto back = dofs_on(body.mesh, "back", "z");
  fixed.insert(fixed.end(), back.begin(), back.end());
  for (const int node : body.mesh.nodes_of("left")) {
    if (distance(body.mesh.place(node), {0, 0, 0}) < 1e-12) fixed.push_back(3 * node + 1);
  }
  std::ranges::sort(fixed);
  return value_at(body.mesh, at_rest(body, force, held(fixed)), {4, 0, 0}).y;
}

TEST(Space, BentBeamConvergesToTheoryWithOrderTwo) {
  constexpr double exact = 0.5 * 4 * 4;  // kappa L^2 / 2, kappa = 1
  for (const Formulation formulation : {Formulation::p1, Formulation::p1_averaged}) {
    const double coarse = tip_deflection(1, formulation);
    const double fine = tip_deflection(2, formulation);
    EXPECT_LT(fine, exact);  // too stiff, as linear elements are
    EXPECT_GT(order(exact - coarse, exact - fine), 1.4) << coarse << " " << fine;
    EXPECT_NEAR(fine, exact, 0.15 * exact);
  }
  EXPECT_NEAR(tip_deflection(1, Formulation::p2), exact, 1e-9 * exact);  // it is quadratic
}

// Vertical displacement at (48, 52) of Cook's membrane in plane strain, by rollers on both sides along z.
double cook(double nu, Formulation formulation) {
  constexpr double depth = 6;
  const int n = formulation == Formulation::p2 ? 8 : 16;
  MeshData data = bricks({1, 1, 0.125}, {n, n, 2});
  for (std::size_t i = 0; i < data.coordinates.size(); i += 3) {
    const double x = data.coordinates[i];
    const double y = data.coordinates[i + 1];
    data.coordinates[i] = 48 * x;
    data.coordinates[i + 1] = 44 * x + y * (44 - 28 * x);
    data.coordinates[i + 2] *= depth / 0.125;
  }
  Slab body(std::move(data), solid({1, nu, 1}, formulation));
  auto fixed = dofs_on(body.mesh, "left");
  for (const char* side : {"back", "front"}) {
    const auto rollers = dofs_on(body.mesh, side, "z");
    fixed.insert(fixed.end(), rollers.begin(), rollers.end());
  }
  std::ranges::sort(fixed);
  fixed.erase(std::unique(fixed.begin(), fixed.end()), fixed.end());
  const auto force = traction_on(body.mesh, "right", {0, 1.0 / 16, 0});  // 1 per length of depth
  const auto u = at_rest(body, force, held(fixed));
  double mean = 0;  // Simpson over the depth
  for (const auto& [z, weight] : {std::pair(0.0, 1.0), {depth / 2, 4.0}, {depth, 1.0}}) {
    mean += weight / 6 * value_at(body.mesh, u, {48, 52, z}).y;
  }
  return mean;
}

TEST(Space, CookBetweenRollers) {
  // A high-order computation in plane strain (tests/README.md), and errors in % of six tetrahedra a brick
  // on 16 x 16 x 2 bricks, quadratic ones on 8 x 8 x 2, by an independent program.
  struct Known {
    double nu, exact, p1, averaged, p2;
  };
  for (const auto& known : {Known{0.3, 21.9450, -3.3, -2.8, -0.2},
                            {0.49, 18.7367, -5.8, -3.6, -1.0},
                            {0.4999, 18.512, -6.7, -4.7, -1.2}}) {
    const double p1 = 100 * (cook(known.nu, Formulation::p1) / known.exact - 1);
    const double averaged = 100 * (cook(known.nu, Formulation::p1_averaged) / known.exact - 1);
    EXPECT_NEAR(p1, known.p1, 0.2) << known.nu;
    EXPECT_NEAR(averaged, known.averaged, 0.2) << known.nu;
    const double p2 = 100 * (cook(known.nu, Formulation::p2) / known.exact - 1);
    EXPECT_NEAR(p2, known.p2, 0.1) << known.nu;
    RecordProperty("p2 at nu " + std::to_string(known.nu), std::to_string(p2));
    RecordProperty("p1 at nu " + std::to_string(known.nu), std::to_string(p1));
    RecordProperty("averaged at nu " + std::to_string(known.nu), std::to_string(averaged));
  }
}

}  // namespace
}  // namespace stylet
