#include "stylet/needle/embedded_track.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/mesh/box.hpp"
#include "stylet/mesh/quadratic.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace stylet {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

// Bricks of 5 mm, shaken, 60 x 50 x 40 mm; the inner ball is stiffer.
Mesh make_body(bool quadratic = false) {
  BoxMesh p;
  p.width = 0.06;
  p.height = 0.05;
  p.depth = 0.04;
  p.columns = 12;
  p.rows = 10;
  p.layers = 8;
  p.jitter = 0.2;
  MeshData data = make_box(p);
  if (quadratic) add_mid_edge_nodes(data);
  return Mesh(std::move(data));
}

const std::vector<RegionModuli> soft{{20e3, 0.3}};

TrackLayout layout(double kernel_radius = 8e-3) {
  return {0.635e-3, kernel_radius, 1e-3, 8, false};
}

constexpr Component all[] = {Component::along, Component::across, Component::across_too};

// u = c + A x
Vector3 affine(ReferencePlace x) {
  return {0.1 + 2 * x.x - 3 * x.y + 0.5 * x.z, -0.2 + x.x + 4 * x.y - x.z,
          0.3 - x.x + 0.2 * x.y + 3 * x.z};
}

double felt(const Mesh& mesh, const SparseRow& row) {
  double sum = 0;
  for (const auto& [dof, value] : row) {
    const Vector3 u = affine(mesh.place(dof / 3));
    const double component[] = {u.x, u.y, u.z};
    sum += value * component[dof % 3];
  }
  return sum;
}

ReferencePlace middle(const EmbeddedTrack& track, int point) {
  const TrackSegment& segment = track.segment(point);
  return track.at((segment.from + segment.to) / 2);
}

// Rows of what lies inside are exact for affine fields, so forces and their moments are.
TEST(EmbeddedTrack, FeelsAffineFieldsInTheMiddleOfASegment) {
  for (const bool quadratic : {false, true}) {
    const Mesh mesh = make_body(quadratic);
    const EmbeddedTrack track(mesh, {0, 0.015, 0.02}, {0.9, 0.3, -0.1}, 0.05, layout(), soft);
    ASSERT_EQ(track.size(), 50);
    for (int point = 12; point < 40; ++point) {
      for (const Component component : all) {
        const double exact = dot(affine(middle(track, point)), track.direction(component));
        EXPECT_NEAR(felt(mesh, track.row({point, component})), exact, 8e-15) << point;
      }
    }
  }
}

TEST(EmbeddedTrack, ForcesAndMomentsOnTheMeshAreThoseOfTheNeedle) {
  const Mesh mesh = make_body();
  const EmbeddedTrack track(mesh, {-0.03, 0.025, 0.02}, {1, 0, 0}, 0.05, layout(), soft);
  for (int point = 0; point < track.size(); ++point) {
    for (const Component component : all) {
      Vector3 force;
      Vector3 moment;
      for (const auto& [dof, value] : track.row({point, component})) {
        Vector3 f;
        (dof % 3 == 0 ? f.x : dof % 3 == 1 ? f.y : f.z) = value;
        force = force + f;
        moment = moment + cross(mesh.place(dof / 3) - middle(track, point), f);
      }
      EXPECT_LT(norm(force - track.direction(component)), 4e-15);
      EXPECT_LT(norm(moment), 1e-16);  // m
    }
  }
}

TEST(EmbeddedTrack, DirectionsAreOrthogonal) {
  const Mesh mesh = make_body();
  for (const Vector3 direction : {Vector3{2, 0, 0}, {0.3, -0.1, 0.2}, {1, 1e-9, 0}}) {
    const EmbeddedTrack track(mesh, {0, 0.025, 0.02}, direction, 0.005, layout(), soft);
    EXPECT_GT(dot(track.direction(Component::along), direction), 0);
    for (const Component a : all) {
      for (const Component b : all) {
        EXPECT_NEAR(dot(track.direction(a), track.direction(b)), a == b ? 1 : 0, 4e-16);
      }
    }
  }
}

// A needle that enters at an angle: part of the kernel is outside, the rest stands in for it.
TEST(EmbeddedTrack, PointsOutsideAreLeftOut) {
  const Mesh mesh = make_body();
  const EmbeddedTrack track(mesh, {-0.01, 0.01, 0.02}, {1, 0.5, 0}, 0.03, layout(), soft);
  EXPECT_NEAR(track.skin().x, 0, 1e-12);
  EXPECT_NEAR(track.skin().y, 0.015, 1e-12);
  for (int point = 0; point < track.size(); ++point) {
    double sum = 0;
    double depth = 0;
    for (const auto& [dof, value] : track.row({point, Component::across})) {
      if (dof % 3 != 2) continue;
      sum += value;
      depth += value * mesh.place(dof / 3).x;
    }
    EXPECT_NEAR(sum, 1, 1e-14);
    EXPECT_GE(depth, middle(track, point).x - 1e-9);
  }
}

TEST(EmbeddedTrack, TheLastSegmentTakesWhatIsLeft) {
  const Mesh mesh = make_body();
  for (const auto& [depth, size, last] : {std::tuple(0.0104, 10, 1.4e-3), {0.0106, 11, 0.6e-3}}) {
    const EmbeddedTrack track(mesh, {0, 0.025, 0.02}, {1, 0, 0}, depth, layout(), soft);
    EXPECT_EQ(track.size(), size);
    EXPECT_NEAR(track.segment(size - 1).length(), last, 1e-9);
  }
  const EmbeddedTrack through(mesh, {0, 0.025, 0.02}, {1, 0, 0}, 1, layout(), soft);
  EXPECT_EQ(through.size(), 60);
  EXPECT_NEAR(through.segment(59).to, 0.06, 1e-9);
}

TEST(EmbeddedTrack, AKernelOfTheNeedlesOwnRadiusLeavesOutNothing) {
  const Mesh mesh = make_body();
  const EmbeddedTrack track(mesh, {0, 0.025, 0.02}, {1, 0, 0}, 0.02, layout(0.5e-3), soft);
  EXPECT_EQ(track.rest({3, Component::along}, {3, Component::along}), 0);
  EXPECT_GT(track.row({3, Component::along}).size(), 3u);
}

TEST(EmbeddedTrack, ComplianceTakesTheModuliOfTheRegions) {
  BoxMesh p;
  p.width = 0.06;
  p.height = 0.05;
  p.depth = 0.04;
  p.columns = 24;
  p.rows = 20;
  p.layers = 16;
  SolidRegion ball;
  ball.name = "ball";
  ball.ellipsoid = {{0.03, 0.025, 0.02}, 0.024, 0.024, 0.024};
  p.inner_regions = {ball};
  const Mesh mesh(make_box(p));
  const std::vector<RegionModuli> two{{20e3, 0.3}, {80e3, 0.3}};
  const EmbeddedTrack track(mesh, {0, 0.025, 0.02}, {1, 0, 0}, 0.06, layout(), two);
  EXPECT_EQ(track.segment(5).shear_modulus, 20e3);
  EXPECT_EQ(track.segment(30).shear_modulus, 80e3);
  const auto rest = [&](int a, int b) {
    return track.rest({a, Component::along}, {b, Component::along});
  };
  EXPECT_NEAR(rest(30, 30) / rest(5, 5), 0.25, 1e-12);
  EXPECT_EQ(track.rest({5, Component::along}, {5, Component::across}), 0);
  EXPECT_EQ(track.rest({5, Component::across}, {6, Component::across}),
            track.rest({5, Component::across_too}, {6, Component::across_too}));
}

// Wherever a load begins and ends: its own compliance is that of the even load.
TEST(EmbeddedTrack, EvenLoadsBetweenTheEndsOfSegments) {
  const Mesh mesh = make_body();
  const EmbeddedTrack track(mesh, {0, 0.025, 0.02}, {1, 0, 0}, 0.03, layout(), soft);
  const RestCompliance exact(0.635e-3, kernel_rings(8e-3, 0.635e-3, 8), 0.03, false);
  for (const double to : {0.02, 0.0203, 0.0205, 0.0209}) {
    const double from = to - 0.006;
    double total = 0;
    double own = track.rest_of_ends(from, to);
    const auto shares = track.shares(from, to);
    for (const auto& [i, share] : shares) {
      total += share;
      for (const auto& [j, other] : shares) {
        own += share * other * track.rest({i, Component::along}, {j, Component::along});
      }
    }
    EXPECT_NEAR(total, 1, 1e-14);
    const TrackSegment zone{from, to, 20e3, 0.3};
    EXPECT_NEAR(own / exact.along(zone, zone), 1, 1e-10) << to;
  }
  EXPECT_NEAR(track.rest_of_ends(0.014, 0.02) * 20e3, 0, 1e-10);
  EXPECT_GT(track.rest_of_ends(0.0145, 0.0205) * 20e3, 0.1);  // 1/m
}

TEST(EmbeddedTrack, WhatMissesTheTissueIsRefused) {
  const Mesh mesh = make_body();
  EXPECT_THAT(
      [&] {
        EmbeddedTrack(mesh, {-0.01, 0.06, 0.02}, {1, 0, 0}, 0.02, layout(), soft);
      },
      ThrowsMessage<InputError>(
          "a needle at (-10, 60, 20) mm in direction (1, 0, 0) misses the tissue"));
  EXPECT_THAT(
      [&] {
        EmbeddedTrack(mesh, {0.001, 0.025, 0.02}, {2, 0, 0}, 0.02, layout(), soft);
      },
      ThrowsMessage<InputError>(
          "a needle at (1, 25, 20) mm in direction (1, 0, 0) begins inside the "
          "tissue: it has to begin on the skin, or before it"));
  EXPECT_THAT(
      [&] {
        EmbeddedTrack(mesh, {-0.01, 0.025, 0.02}, {1, 0, 0}, 0.02, layout(0.09), soft);
      },
      ThrowsMessage<InputError>(HasSubstr("lies outside the tissue by more than three quarters at "
                                          "(0, 25, 20) mm")));
}

}  // namespace
}  // namespace stylet
