// The needle of support/can.hpp across a plane jump of stiffness, 15 mm deep, between faces of tetrahedra: the near
// field of each segment is of its own tissue. The known answers are of an axisymmetric computation with quadratic
// elements, with the needle's radius and segments of 1 mm, by another program.
#include "support/can.hpp"
#include <gtest/gtest.h>

#include <array>

namespace stylet {
namespace {

/// Forces of the stuck needle (N/mm), along and across; of the tip (mm/N) by its own load, along and across.
using Answers = std::array<double, 4>;

Answers answers(const CanCase& c) {
  Can can(c);
  const double shaft = c.depth - Can::tip_length;
  return {can.stuck(Component::along), can.stuck(Component::across),
          can.tip(Component::along, c.depth, shaft, c.depth),
          can.tip(Component::across, c.depth, shaft, c.depth)};
}

struct Layers {
  double stiffer;
  Answers exact;
  Answers split;  ///< %: what is left of a kernel of 10 mm on the finest of all meshes, nearly
};
constexpr std::array<Layers, 2> all_layers{
    {{3.0, {3.2227, 5.1111, 0.6885, 0.5359}, {2.5, 1.2, -0.2, 0.0}},
     {1.0 / 3, {0.7130, 1.3620, 6.0464, 4.7508}, {4.7, 1.4, 0.5, 0.2}}}};

TEST(TrackInSpace, ConvergesAcrossAJumpOfStiffness) {
  struct Meshes {
    const char* coarse;
    Formulation formulation;
    double largest;  ///< % of the fine mesh
  };
  // 1914 tetrahedra, or 689 of the quadratic ones, and their refinements.
  for (const Meshes& meshes : {Meshes{STYLET_LAYERED_CAN_MESH, Formulation::p1_averaged, 4},
                               {STYLET_COARSE_LAYERED_CAN_MESH, Formulation::p2, 1.6}}) {
    for (const Layers& layers : all_layers) {
      CanCase c{meshes.coarse, 0, 0.45, meshes.formulation, 0.035, layers.stiffer};
      const Answers coarse = answers(c);
      c.refinements = 1;
      const Answers fine = answers(c);
      for (std::size_t i = 0; i < coarse.size(); ++i) {
        const auto left = [&](const Answers& found) {
          return 100 * (found[i] / layers.exact[i] - 1) - layers.split[i];
        };
        EXPECT_LT(std::abs(left(fine)), meshes.largest) << layers.stiffer << " " << i;
        EXPECT_GT(order(std::abs(left(coarse)), std::abs(left(fine))), 1.2)
            << layers.stiffer << " " << i;
        RecordProperty("error_" + std::to_string(i) + "_" +
                           std::to_string(static_cast<int>(meshes.formulation)) +
                           (layers.stiffer > 1 ? "_stiffer" : "_softer"),
                       std::to_string(left(coarse) + layers.split[i]) + " " +
                           std::to_string(left(fine) + layers.split[i]));
      }
    }
  }
}

}  // namespace
}  // namespace stylet
