// The needle of support/can.hpp bends: 1 N across on the last 6 mm of a cannula that is held by a guide outside the
// skin, tissue along all of its shaft. With forces p on the needle and lambda on the tissue,
//
//   ubar = W lambda = F (p - lambda),   (W + F) lambda = F p
//
// F: flexibility of the cantilever. So the track, whose compliance has F beside it, is moved by F p. The known answers
// are of an axisymmetric computation with the same beam by another program.
#include "support/beam.hpp"
#include "support/can.hpp"
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace stylet {
namespace {

constexpr double cannula = 20652e-6;  // N m^2, of 18G
constexpr double depth = 0.035;

/// Mean displacement (mm) of the tip's zone by 1 N on it; outside: guide to skin (m).
double bent(double outside, const CanCase& c) {
  const Cantilever beam{cannula, outside};
  Can can(c, [&](const EmbeddedTrack& track) { return std::make_unique<BentTrack>(track, beam); });
  const EmbeddedTrack& track = can.track();
  const auto deflection = [&](const std::vector<double>& forces) {
    std::vector<double> sum;
    for (int k = 0; k < track.size(); ++k) {
      sum.push_back(0);
      for (int j = 0; j < track.size(); ++j) {
        sum.back() += flexibility(beam, track.segment(k), track.segment(j)) *
                      forces[static_cast<std::size_t>(j)];
      }
    }
    return sum;
  };
  std::vector<double> net(static_cast<std::size_t>(track.size()), 0.0);
  const auto zone = track.shares(depth - Can::tip_length, depth);
  for (const auto& [point, share] : zone) net[static_cast<std::size_t>(point)] = share;
  const auto on_tissue = can.moved(Component::across, deflection(net));
  for (std::size_t k = 0; k < net.size(); ++k) net[k] -= on_tissue[k];
  const auto place = deflection(net);
  double mean = 0;
  for (const auto& [point, share] : zone) mean += share * place[static_cast<std::size_t>(point)];
  return 1e3 * mean;
}

TEST(Cantilever, HasTheFlexibilityOfBeamTheory) {
  const Cantilever beam{cannula, 0.05};
  const auto at = [](double s) { return TrackSegment{s, s + 1e-9, 0, 0}; };
  const double a = 0.05 + 0.02;
  const double b = 0.05 + 0.035;
  EXPECT_NEAR(flexibility(beam, at(0.035), at(0.035)) * 3 * cannula / (b * b * b), 1, 1e-6);
  EXPECT_NEAR(flexibility(beam, at(0.02), at(0.035)) * 6 * cannula / (a * a * (3 * b - a)), 1,
              1e-6);
  // An even load on all of a beam: mean deflection p L^4 / 20 E I.
  const TrackSegment all{0, 0.035, 0, 0};
  EXPECT_NEAR(flexibility({cannula, 0}, all, all) * 20 * cannula / std::pow(0.035, 3), 1, 1e-12);
}

TEST(TrackInSpace, ANeedleThatBendsConverges) {
  struct Known {
    double outside;  ///< mm
    double tip;      ///< mm
  };
  for (const Known& known : {Known{0, 0.360}, {50, 0.702}, {100, 0.706}}) {
    for (const Formulation formulation : {Formulation::p1_averaged, Formulation::p2}) {
      const bool quadratic = formulation == Formulation::p2;
      CanCase c{quadratic ? STYLET_COARSE_CAN_MESH : STYLET_CAN_MESH, 0, 0.45, formulation};
      const auto error = [&] { return bent(1e-3 * known.outside, c) / known.tip - 1; };
      const double coarse = error();
      c.refinements = 1;
      const double fine = error();
      // Known to three digits.
      EXPECT_LT(std::abs(coarse), quadratic ? 0.03 : 0.06) << known.outside;
      EXPECT_LT(std::abs(fine), quadratic ? 0.005 : 0.02) << known.outside;
      EXPECT_GT(order(std::abs(coarse), std::abs(fine)), quadratic ? 1.7 : 1.4) << known.outside;
      RecordProperty("error_" + std::to_string(known.outside) + (quadratic ? "_p2" : ""),
                     std::to_string(coarse) + " " + std::to_string(fine));
    }
  }
}

}  // namespace
}  // namespace stylet
