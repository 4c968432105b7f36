// Triangular solves along paths of the elimination tree, and their shares of the ranks, against
// products with the operator.
#include "stylet/base/errors.hpp"
#include "stylet/dynamics/state.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/solvers/cholesky.hpp"

#include "support/scenes.hpp"
#include <gtest/gtest.h>

#include <random>

namespace stylet {
namespace {

// Round-off, times the condition of K + 1e4/s^2 M: the largest omega^2, 1e7 to 1e9, over 1e4.
constexpr double tolerance = 1e-11;

const std::string block = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 1, rows: 1, jitter: 0.2}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
supports: {left: fixed}
time: {step: 10 ms, duration: 20 ms}
)";

double size_of_values(const std::vector<double>& values) {
  double size = 0;
  for (const double value : values) size = std::max(size, std::abs(value));
  return size;
}

// Minimum degree orders the smaller mesh, nested dissection the larger one.
class CholeskyOf : public testing::TestWithParam<int> {
 protected:
  CholeskyOf() {
    const int rows = GetParam();
    scene = scene_of(block, {"mesh.rectangle.columns=" + std::to_string(rows + 9),
                             "mesh.rectangle.rows=" + std::to_string(rows)});
    numbered.emplace(make_mesh(MPI_COMM_WORLD, scene));
    tissue = make_tissue(MPI_COMM_WORLD, scene, *numbered);
    tissue->make_tangent({1e4, 1});
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int dof = 0; dof < tissue->n_dofs(); ++dof) field.push_back(any(random));
    std::uniform_int_distribution<int> one(0, tissue->n_dofs() - 1);
    while (dofs.size() < 40) {
      const int dof = one(random);
      if (std::ranges::find(dofs, dof) == dofs.end()) dofs.push_back(dof);
    }
    for (std::size_t i = 0; i < dofs.size(); ++i) forces.push_back(any(random));
  }
  [[nodiscard]] Mat a() const { return tissue->tangent_matrix(); }
  [[nodiscard]] OwnedVec vector_of(const std::vector<double>& values) const {
    OwnedVec vec = tissue->make_vector();
    Entries entries(vec.get());
    for (int dof = tissue->first_dof(); dof < tissue->end_dof(); ++dof) {
      entries[dof] = values[static_cast<std::size_t>(dof)];
    }
    return vec;
  }
  [[nodiscard]] std::vector<double> product(Vec x) const {
    OwnedVec y = tissue->make_vector();
    check(MatMult(a(), x, y.get()));
    return gather_all(y.get());
  }
  void expect_solves(Cholesky& factor) const {
    const double scale = size_of_values(field);
    // b = A field
    const OwnedVec exact = vector_of(field);
    const OwnedVec b = vector_of(product(exact.get()));
    factor.load(b.get());
    const auto some = factor.loaded(dofs);
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      EXPECT_NEAR(some[i], field[static_cast<std::size_t>(dofs[i])], tolerance * scale);
    }
    OwnedVec x = tissue->make_vector();
    factor.respond({}, {}, true, x.get());
    expect_near(gather_all(x.get()), field, scale);

    OwnedVec response = tissue->make_vector();
    factor.respond(dofs, forces, false, response.get());
    std::vector<double> pushed(field.size(), 0.0);
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      pushed[static_cast<std::size_t>(dofs[i])] = forces[i];
    }
    expect_near(product(response.get()), pushed, 1);

    factor.respond(dofs, forces, true, x.get());
    check(VecAXPY(x.get(), -1, response.get()));
    expect_near(gather_all(x.get()), field, scale);

    const auto columns = std::span(dofs).first(35);
    const auto entries = factor.inverse_entries(dofs, columns);
    std::vector<double> sums(dofs.size(), 0.0);
    for (std::size_t j = 0; j < columns.size(); ++j) {
      for (std::size_t i = 0; i < dofs.size(); ++i) {
        sums[i] += entries[j * dofs.size() + i] * forces[j];
      }
    }
    factor.respond(columns, std::span(forces).first(columns.size()), false, response.get());
    const auto expected = gather_all(response.get());
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      EXPECT_NEAR(sums[i], expected[static_cast<std::size_t>(dofs[i])],
                  tolerance * size_of_values(expected));
    }

    factor.unload();
    EXPECT_EQ(size_of_values(factor.loaded(dofs)), 0);
  }
  static void expect_near(const std::vector<double>& got,
                          const std::vector<double>& expected,
                          double scale) {
    double worst = 0;
    for (std::size_t i = 0; i < got.size(); ++i) {
      worst = std::max(worst, std::abs(got[i] - expected[i]));
    }
    EXPECT_LT(worst, tolerance * scale);
  }

  Scene scene;
  std::optional<NumberedMesh> numbered;
  std::unique_ptr<TissueOperator> tissue;
  std::vector<double> field;
  std::vector<int> dofs;
  std::vector<double> forces;
};
INSTANTIATE_TEST_SUITE_P(Rows, CholeskyOf, testing::Values(1, 30, 75));

TEST_P(CholeskyOf, SolvesAlongPathsAndAsAWhole) {
  Cholesky factor(MPI_COMM_WORLD, tissue->n_dofs());
  factor.factor(a());
  expect_solves(factor);
}

TEST_P(CholeskyOf, TakesNewNumbersAndNewPatterns) {
  Cholesky factor(MPI_COMM_WORLD, tissue->n_dofs());
  factor.factor(a());
  check(MatScale(a(), 3));
  factor.factor(a());
  expect_solves(factor);
  tissue->make_tangent({5e4, 1});
  factor.factor(a());
  expect_solves(factor);
}

TEST_P(CholeskyOf, RefusesAnIndefiniteOperator) {
  tissue->make_tangent({-1e7, 1});
  Cholesky factor(MPI_COMM_WORLD, tissue->n_dofs());
  EXPECT_THROW(factor.factor(a()), NumericalError);
}

}  // namespace
}  // namespace stylet
