#include "stylet/study/field_sample.hpp"

#include "stylet/mesh/box.hpp"
#include "stylet/mesh/quadratic.hpp"
#include "stylet/mesh/rectangle.hpp"
#include "stylet/mesh/refine.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace stylet {
namespace {

using Function = std::function<double(double, double)>;

FieldSample sampled(int refinements, const Function& f) {
  RectangleMesh square;
  square.width = square.height = 1;
  square.columns = square.rows = 4;
  const MeshData data = refine(make_rectangle(square), refinements);
  FieldSample sample{0, data.coordinates, data.cells, {}};
  for (std::size_t i = 0; i < data.coordinates.size(); i += 2) {
    sample.u.push_back(f(data.coordinates[i], data.coordinates[i + 1]));
    sample.u.push_back(0);
  }
  return sample;
}

TEST(FieldSample, LinearFieldsAreTheSameOnNestedMeshes) {
  const Function linear = [](double x, double y) { return 1 + 2 * x - y; };
  EXPECT_LT(relative_distance(sampled(0, linear), sampled(2, linear)), 1e-15);
}

// Interpolation of a smooth field is of order two.
TEST(FieldSample, DistanceOfInterpolantsIsOfSecondOrder) {
  const Function smooth = [](double x, double y) { return std::sin(3 * x) * std::cos(2 * y); };
  const auto fine = sampled(4, smooth);
  const double coarse = relative_distance(sampled(1, smooth), fine);
  const double middle = relative_distance(sampled(2, smooth), fine);
  // Distances to the finest mesh instead of the limit: (1 - 1/64) / (1/4 - 1/64) = 4.2.
  EXPECT_NEAR(coarse / middle, 4.2, 0.1);
}

// Not a half of the coarse field but of the fine one.
TEST(FieldSample, RelativeToTheFineField) {
  const Function one = [](double, double) { return 1.0; };
  const Function two = [](double, double) { return 2.0; };
  EXPECT_NEAR(relative_distance(sampled(0, one), sampled(1, two)), 0.5, 1e-15);
}

// Squares of quadratic fields are of degree four: ||1 - x^2|| / ||x^2|| in the unit cube.
TEST(FieldSample, QuadraticFieldsAreIntegratedExactly) {
  BoxMesh cube;
  cube.width = cube.height = cube.depth = 1;
  cube.columns = cube.rows = cube.layers = 1;
  const auto cubic = [&cube](int refinements, const std::function<double(double)>& f) {
    MeshData data = refine(make_box(cube), refinements);
    add_mid_edge_nodes(data);
    FieldSample sample{0, data.coordinates, data.cells, {}};
    sample.dim = 3;
    sample.quadratic_cells = data.quadratic_cells;
    for (std::size_t i = 0; i < data.coordinates.size(); i += 3) {
      sample.u.insert(sample.u.end(), {f(data.coordinates[i]), 0, 0});
    }
    return sample;
  };
  const auto fine = cubic(1, [](double x) { return x * x; });
  EXPECT_NEAR(relative_distance(cubic(0, [](double) { return 1.0; }), fine), std::sqrt(8.0 / 3),
              1e-14);
  EXPECT_LT(relative_distance(cubic(0, [](double x) { return x * x; }), fine), 1e-14);
}

TEST(FieldSample, FilesComeBack) {
  const auto sample = sampled(0, [](double x, double y) { return x / 3 + y; });
  const std::string path = testing::TempDir() + "fields.cbor";
  write_fields(path, {sample});
  const auto back = read_fields(path);
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].u, sample.u);
  EXPECT_EQ(back[0].cells, sample.cells);
}

}  // namespace
}  // namespace stylet
