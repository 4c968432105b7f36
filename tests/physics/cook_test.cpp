// Cook's membrane in plane strain, nu = 0.3: a tapered plate held on the left under shear.
#include "stylet/dynamics/implicit_newmark.hpp"

#include "support/body.hpp"
#include <gtest/gtest.h>

namespace stylet {
namespace {

// Corners (0,0), (48,44), (48,60), (0,44).
MeshData cook_mesh(int n) {
  MeshData data = rectangle({.columns = n, .rows = n});
  for (std::size_t i = 0; i < data.coordinates.size(); i += 2) {
    const double x = data.coordinates[i];
    const double y = data.coordinates[i + 1];
    data.coordinates[i] = 48 * x;
    data.coordinates[i + 1] = 44 * x + y * (44 - 28 * x);
  }
  return data;
}

struct CookAnswer {
  double middle;  ///< vertical displacement at (48, 52)
  double corner;  ///< at (48, 60)
};

CookAnswer solve(int n) {
  Body body(cook_mesh(n), material({1, 0.3, 0}, Plane::strain));
  std::vector<double> force(static_cast<std::size_t>(body.tissue.n_dofs()), 0.0);
  for (const int f : body.mesh.facets_of("right")) {
    for (std::size_t end = 0; end < 2; ++end) {
      const auto node =
          static_cast<std::size_t>(body.mesh.data().facets[2 * static_cast<std::size_t>(f) + end]);
      force[2 * node + 1] += 0.5 / n;  // a total of 1
    }
  }
  const OwnedVec load = vector_of(body.tissue, force);
  TimeParameters time;
  time.method = TimeMethod::quasi_static;
  ImplicitNewmark integrator(body.tissue, time);
  State state = still(body.tissue);
  step(integrator, state, load.get(), 1, held(dofs_of(body.mesh, {"left"})));
  const auto u = gather_all(state.u.get());
  CookAnswer answer{};
  for (const int node : body.mesh.nodes_of("right")) {
    const double y = body.mesh.point(node).y;
    const double value = u[2 * static_cast<std::size_t>(node) + 1];
    if (std::abs(y - 52) < 1e-9) answer.middle = value;
    if (std::abs(y - 60) < 1e-9) answer.corner = value;
  }
  return answer;
}

TEST(Cook, DisplacementsConvergeToAHighOrderComputation) {
  constexpr double middle = 21.9450;
  constexpr double corner = 23.0567;
  const CookAnswer coarse = solve(32);
  const CookAnswer fine = solve(64);
  // Too stiff, as linear triangles are.
  EXPECT_LT(fine.middle, middle);
  EXPECT_LT(fine.corner, corner);
  // The held side ends in a singular corner; at the loaded side's own corner the traction does not
  // fit the free top, which costs more.
  const double order_middle = order(middle - coarse.middle, middle - fine.middle);
  const double order_corner = order(corner - coarse.corner, corner - fine.corner);
  EXPECT_GT(order_middle, 1.5);
  EXPECT_LT(order_middle, 2.1);
  EXPECT_GT(order_corner, 1.1);
  EXPECT_LT(order_corner, 2.1);
  EXPECT_NEAR(fine.middle, middle, 0.005 * middle);
  EXPECT_NEAR(fine.corner, corner, 0.01 * corner);
  RecordProperty("middle", std::to_string(fine.middle));
  RecordProperty("corner", std::to_string(fine.corner));
  RecordProperty("order_middle", std::to_string(order_middle));
  RecordProperty("order_corner", std::to_string(order_corner));
}

}  // namespace
}  // namespace stylet
