// The needle of track_test.cpp as it goes in by its laws: cutting force 1.7 N over 6 mm, friction 130 N/m. How
// far the tip drags the tissue along by the time it has cut to a depth is known of an axisymmetric computation
// with quadratic elements by another program.
#include "support/body.hpp"
#include "support/jitter.hpp"
#include "support/scenes.hpp"
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace stylet {
namespace {

const std::string inserted = R"(
mesh: {file: )" STYLET_CAN_MESH R"(, scale: 0.001}
tissue:
  formulation: p1_averaged
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
supports: {side: fixed, bottom: fixed}
needles:
  - entry: [0 mm, 0 mm, 70 mm]
    direction: [0, 0, -2]
    kernel_radius: 10 mm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction:
      {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 0.5 mm/s, slip_speed: 1 mm/s}
    motion: [insert: {speed: 5 mm/s, depth: 39.6 mm}]
time: {method: quasi_static, step: 50 ms}
)";

/// By depth that is cut (m): how far the tip is ahead of it (m), and the needle's force (N).
struct Course {
  std::vector<double> depth;
  std::vector<double> drag;
  std::vector<double> force;
  double dissipated = 0;
  double external = 0;
  double strain = 0;

  [[nodiscard]] double at(double cut, const std::vector<double>& values) const {
    std::size_t i = 1;
    while (depth[i] < cut) ++i;
    const double share = (cut - depth[i - 1]) / (depth[i] - depth[i - 1]);
    return values[i - 1] + share * (values[i] - values[i - 1]);
  }
};

Course course_of(const std::vector<std::string>& changes) {
  Simulation simulation(MPI_COMM_WORLD, scene_of(inserted, changes), true);
  Course course;
  run_to_end(simulation, [&](const StepRecord& record) {
    const double cut = simulation.needle()->path_length();
    course.depth.push_back(cut);
    course.drag.push_back(simulation.needle()->tip() - cut);
    course.force.push_back(record.needle.forces.total());
  });
  course.dissipated = simulation.energies().dissipated;
  course.external = simulation.energies().external;
  course.strain = simulation.energies().strain;
  return course;
}

TEST(TrackInSpace, AnInsertionConvergesToTheNeedlesRadius) {
  struct Known {
    const char* poisson_ratio;
    double drag[3];  // mm, at 15, 25 and 35 mm
  };
  for (const Known& known :
       {Known{"0.45", {4.625, 4.558, 4.493}}, Known{"0.49", {4.521, 4.412, 4.339}}}) {
    double error[2][3];
    for (const int refinements : {0, 1}) {
      const Course course =
          course_of({"mesh.refine=" + std::to_string(refinements),
                     std::string("tissue.regions.tissue.poisson_ratio=") + known.poisson_ratio});
      for (int i = 0; i < 3; ++i) {
        const double cut = 0.015 + 0.01 * i;
        error[refinements][i] = 1e3 * course.at(cut, course.drag) / known.drag[i] - 1;
        // Friction bears on all of the shaft behind the tip.
        EXPECT_NEAR(course.at(cut, course.force), 1.7 + 130 * (cut - 6e-3), 2e-3);
      }
      // Quasi-static work is booked to the last bit.
      EXPECT_NEAR(course.external, course.strain + course.dissipated, 1e-12 * course.external);
    }
    for (int i = 0; i < 3; ++i) {
      EXPECT_LT(std::abs(error[0][i]), 0.06) << known.poisson_ratio << " " << i;
      EXPECT_LT(std::abs(error[1][i]), 0.015) << known.poisson_ratio << " " << i;
      EXPECT_GT(order(std::abs(error[0][i]), std::abs(error[1][i])), 1.5);
      RecordProperty(std::string("error_") + known.poisson_ratio + "_" + std::to_string(i),
                     std::to_string(error[0][i]) + " " + std::to_string(error[1][i]));
    }
  }
}

TEST(TrackInSpace, AnInsertionThroughQuadraticTetrahedra) {
  const Course course = course_of({"tissue.formulation=p2", "time.step=100 ms"});
  const double known[3] = {4.625, 4.558, 4.493};  // mm
  for (int i = 0; i < 3; ++i) {
    const double cut = 0.015 + 0.01 * i;
    EXPECT_NEAR(1e3 * course.at(cut, course.drag), known[i], 0.01 * known[i]) << cut;
    RecordProperty("drag_" + std::to_string(i), std::to_string(1e3 * course.at(cut, course.drag)));
  }
}

TEST(TrackInSpace, AnInsertionIsTheSameInShorterStepsAndSlowImplicitOnes) {
  const Course longer = course_of({"needles.0.motion.0.insert.depth=20 mm"});
  for (const std::vector<std::string>& changes :
       {std::vector<std::string>{"time.step=11 ms"}, {"time.method=implicit", "time.step=25 ms"}}) {
    std::vector<std::string> all = changes;
    all.emplace_back("needles.0.motion.0.insert.depth=20 mm");
    const Course other = course_of(all);
    EXPECT_NEAR(other.depth.back(), longer.depth.back(), 2e-6) << changes.front();
    EXPECT_NEAR(other.force.back(), longer.force.back(), 1e-3) << changes.front();
  }
}

// Three integrators, one answer: the hand is slow against waves.
TEST(TrackInSpace, AnInsertionIsTheSameInExplicitSteps) {
  const std::string depth = "needles.0.motion.0.insert.depth=10 mm";
  const Course at_rest = course_of({depth});
  const Course waves =
      course_of({depth, "time.method=explicit", "needles.0.cutting.law=consistent"});
  EXPECT_NEAR(waves.depth.back(), at_rest.depth.back(), 2e-6);
  EXPECT_NEAR(waves.force.back(), at_rest.force.back(), 1e-3);
  // Central difference books its work to the last bit.
  EXPECT_NEAR(waves.external, waves.strain + waves.dissipated, 1e-6 * waves.external);
}

TEST(TrackInSpace, AnInsertionGoesSmoothly) {
  const Course course = course_of({"mesh.refine=1", "time.step=20 ms"});
  std::vector<double> drag;
  for (std::size_t i = 0; i < course.depth.size(); ++i) {
    if (course.depth[i] > 0.02 && course.depth[i] < 0.03) drag.push_back(course.drag[i]);
  }
  ASSERT_GT(drag.size(), 50U);
  const double left = jitter(drag);
  EXPECT_LT(left, 5e-4);
  RecordProperty("jitter", std::to_string(left));
}

}  // namespace
}  // namespace stylet
