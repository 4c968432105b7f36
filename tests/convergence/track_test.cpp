// The needle of support/can.hpp. The known answers are of an axisymmetric computation with quadratic elements
// down to 0.04 mm by another program.
#include "support/can.hpp"
#include "support/jitter.hpp"
#include <gtest/gtest.h>

#include <array>

namespace stylet {
namespace {

/// Forces of the stuck needle (N/mm), along and across; of the tip (mm/N) by its own load, along and
/// across, and by one that is spread over the shaft behind it.
using Answers = std::array<double, 5>;

/// On 1648 tetrahedra, or 482 of the quadratic ones, and their refinements.
Answers answers(int refinements, double nu, Formulation formulation) {
  const char* const mesh =
      formulation == Formulation::p2 ? STYLET_COARSE_CAN_MESH : STYLET_CAN_MESH;
  Can can({mesh, refinements, nu, formulation});
  constexpr double depth = 0.035;
  constexpr double shaft = depth - Can::tip_length;
  return {can.stuck(Component::along), can.stuck(Component::across),
          can.tip(Component::along, depth, shaft, depth),
          can.tip(Component::across, depth, shaft, depth),
          can.tip(Component::along, depth, 0, shaft)};
}

struct Known {
  double nu;
  Formulation formulation;
  Answers exact;
  Answers coarse;  ///< % by another program with the same method, on like meshes
  Answers fine;
  Answers limit{};  ///< of finer meshes: what the split leaves, where the fine mesh is near it
  double least_order = 1;
  bool same_mesh = true;  ///< else another one of the same size, whose fine answers are compared
};

TEST(TrackInSpace, ConvergesToTheNeedlesRadius) {
  const Known all[] = {{0.3,
                        Formulation::p1,
                        {1.4213, 2.1917, 1.9525, 1.6276, 0.2737},
                        {7.35, 6.12, -4.52, -7.54, -8.15},
                        {1.96, 1.56, -1.62, -3.00, -1.96}},
                       {0.45,
                        Formulation::p1_averaged,
                        {1.3959, 2.3310, 2.0419, 1.5965, 0.2717},
                        {5.71, 5.89, -3.35, -7.25, -6.89},
                        {1.08, 1.27, -1.03, -2.71, -0.91}},
                       {0.45,
                        Formulation::p2,
                        {1.3959, 2.3310, 2.0419, 1.5965, 0.2717},
                        {2.19, 2.07, -2.27, -4.46, -3.14},
                        {-0.52, -0.26, -0.34, -1.14, 1.43},
                        {-0.92, -0.70, 0.16, 0.27, 1.72},
                        1.7,
                        false}};
  for (const Known& known : all) {
    const Answers coarse = answers(0, known.nu, known.formulation);
    const Answers fine = answers(1, known.nu, known.formulation);
    for (std::size_t i = 0; i < known.exact.size(); ++i) {
      const auto percent = [&](double value) { return 100 * (value / known.exact[i] - 1); };
      const double first = percent(coarse[i]);
      const double second = percent(fine[i]);
      // Other points on the rings, and other diagonals where tetrahedra are split.
      const double like = known.same_mesh ? 0.1 : 0.3;
      if (known.same_mesh) {
        EXPECT_NEAR(first, known.coarse[i], like) << known.nu << " " << i;
      }
      EXPECT_NEAR(second, known.fine[i], like) << known.nu << " " << i;
      const double seen =
          order(std::abs(first - known.limit[i]), std::abs(second - known.limit[i]));
      EXPECT_GT(seen, known.least_order) << known.nu << " " << i;
      RecordProperty(
          "error_" + std::to_string(i) + "_" + std::to_string(static_cast<int>(known.formulation)),
          std::to_string(first) + " " + std::to_string(second));
    }
  }
}

// A tip that goes on through the mesh and through its own segments: rms about a cubic.
TEST(TrackInSpace, TheTipsComplianceIsSmooth) {
  Can can({STYLET_CAN_MESH, 1, 0.3, Formulation::p1, 0.04});
  constexpr int n = 90;
  std::vector<double> compliance;
  for (int i = 0; i <= n; ++i) {
    compliance.push_back(can.tip_along(0.0345 + 0.0045 * (2.0 * i / n - 1)));
  }
  const double left = jitter(compliance);
  EXPECT_LT(left, 5e-4);
  RecordProperty("jitter", std::to_string(left));
}

}  // namespace
}  // namespace stylet
