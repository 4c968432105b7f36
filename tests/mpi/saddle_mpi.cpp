// Averaged dilatation in space by its parts: products, and the factor of the saddle form with rows of a track,
// against the assembled operator.
#include "stylet/base/errors.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/solvers/cholesky.hpp"
#include "stylet/solvers/eliminated.hpp"

#include "support/scenes.hpp"
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <set>

namespace stylet {
namespace {

// Two regions, so that nodes between them have two patches.
const std::string block = R"(
mesh:
  box:
    size: [8 cm, 6 cm, 6 cm]
    columns: 7
    rows: 6
    layers: 5
    region: outer
    inner_regions: [{name: inner, ellipsoid: {centre: [4 cm, 3 cm, 3 cm], size: [5 cm, 4 cm, 4 cm]}}]
tissue:
  formulation: p1_averaged
  regions:
    outer: {youngs_modulus: 30 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
    inner: {youngs_modulus: 60 kPa, poisson_ratio: 0.49, density: 1100 kg/m^3}
supports: {left: fixed}
time: {method: implicit, step: 10 ms, duration: 20 ms}
)";

class Saddle : public testing::TestWithParam<const char*> {
 protected:
  Saddle()
      : scene(scene_of(block, {std::string("tissue.regions.inner.poisson_ratio=") + GetParam()})),
        numbered(make_mesh(MPI_COMM_WORLD, scene)),
        tissue(make_tissue(MPI_COMM_WORLD, scene, numbered)),
        factor(MPI_COMM_WORLD, tissue->n_dofs()),
        x(tissue->make_vector()) {
    tissue->make_tangent(combination);
    std::vector<PetscInt> held;
    for (const int node : numbered.mesh.nodes_of("left")) {
      for (int k = 0; k < 3; ++k) {
        if (tissue->owns(node)) held.push_back(3 * node + k - tissue->first_dof());
        is_held.insert(3 * node + k);
      }
    }
    a.take(tissue->tangent_matrix(), held);
    form.take(tissue->saddle(combination), held);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(-1, 1);
    std::uniform_int_distribution<int> one(0, tissue->n_dofs() - 1);
    for (int dof = 0; dof < tissue->n_dofs(); ++dof) {
      field.push_back(is_held.contains(dof) ? 0 : any(random));
    }
    for (int i = 0; i < 40; ++i) {
      std::set<int> dofs;
      while (dofs.size() < 20) {
        const int dof = one(random);
        if (!is_held.contains(dof)) dofs.insert(dof);
      }
      SparseRow row;
      for (const int dof : dofs) row.push_back({dof, any(random)});
      rows.push_back(row);
      forces.push_back(any(random));
    }
  }
  [[nodiscard]] OwnedVec vector_of(const std::vector<double>& values) const {
    OwnedVec vec = tissue->make_vector();
    Entries entries(vec.get());
    for (int dof = tissue->first_dof(); dof < tissue->end_dof(); ++dof) {
      entries[dof] = values[static_cast<std::size_t>(dof)];
    }
    return vec;
  }
  /// B of a field of all dofs.
  [[nodiscard]] std::vector<double> products(const std::vector<double>& of) const {
    std::vector<double> sums;
    for (const auto& row : rows) {
      double sum = 0;
      for (const auto& [dof, weight] : row) sum += weight * of[static_cast<std::size_t>(dof)];
      sums.push_back(sum);
    }
    return sums;
  }
  /// B^T of numbers of all rows.
  [[nodiscard]] std::vector<double> spread(const std::vector<double>& numbers) const {
    std::vector<double> on(field.size(), 0.0);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (const auto& [dof, weight] : rows[i]) {
        on[static_cast<std::size_t>(dof)] += weight * numbers[i];
      }
    }
    return on;
  }
  [[nodiscard]] std::vector<double> solved() const { return gather_all(x.get()); }
  static void expect_near(const std::vector<double>& got, const std::vector<double>& expected) {
    ASSERT_EQ(got.size(), expected.size());
    double size = 0;
    double worst = 0;
    for (std::size_t i = 0; i < got.size(); ++i) {
      size = std::max(size, std::abs(expected[i]));
      worst = std::max(worst, std::abs(got[i] - expected[i]));
    }
    EXPECT_LT(worst, tolerance * size);
  }

  // Round-off times the condition of the operator: lambda is 5000 mu at 0.4999, times (length / edge)^2.
  static constexpr double tolerance = 1e-10;
  static constexpr Combination combination{1e5, 1.5};
  Scene scene;
  NumberedMesh numbered;
  std::unique_ptr<TissueOperator> tissue;
  Eliminated a;
  Eliminated form;
  Cholesky factor;
  OwnedVec x;
  std::set<int> is_held;      ///< dofs, which are cut off
  std::vector<double> field;  ///< zero there
  std::vector<SparseRow> rows;
  std::vector<double> forces;
};
INSTANTIATE_TEST_SUITE_P(PoissonRatio, Saddle, testing::Values("0", "0.4999"));

TEST_P(Saddle, ProductsByPartsAreThoseOfTheMatrix) {
  const OwnedVec u = vector_of(field);
  tissue->apply_stiffness(u.get(), x.get());
  const auto by_parts = solved();
  check(MatMult(tissue->stiffness(), u.get(), x.get()));
  expect_near(by_parts, solved());
}

TEST_P(Saddle, SolvesForDofsAsTheOperatorDoes) {
  factor.factor(a.matrix(), form.matrix());
  const OwnedVec u = vector_of(field);
  OwnedVec b = tissue->make_vector();
  check(MatMult(a.matrix(), u.get(), b.get()));
  factor.load(b.get());
  std::vector<int> dofs;
  for (const auto& row : std::span(rows).first(4)) dofs.push_back(row.front().dof);
  std::vector<double> expected;
  for (const int dof : dofs) expected.push_back(field[static_cast<std::size_t>(dof)]);
  expect_near(factor.loaded(dofs), expected);
  factor.respond({}, {}, true, x.get());
  expect_near(solved(), field);
  const double unit[1] = {1};
  const auto entries = factor.inverse_entries(dofs, dofs);
  for (std::size_t j = 0; j < dofs.size(); ++j) {
    factor.respond(std::span(dofs).subspan(j, 1), unit, false, x.get());
    check(MatMult(a.matrix(), x.get(), b.get()));
    auto forces_on = gather_all(b.get());
    std::vector<double> pushed(field.size(), 0.0);
    pushed[static_cast<std::size_t>(dofs[j])] = 1;
    expect_near(forces_on, pushed);
    const auto column = solved();
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      EXPECT_NEAR(entries[j * dofs.size() + i], column[static_cast<std::size_t>(dofs[i])],
                  tolerance * std::abs(column[static_cast<std::size_t>(dofs[j])]));
    }
  }
}

// Once with the factor of the operator itself, once with that of its saddle form.
TEST_P(Saddle, RowsOfATrackAreSolvedForFromWhatIsKept) {
  for (Mat saddle : {Mat(nullptr), form.matrix()}) {
    factor.factor(a.matrix(), saddle);
    const OwnedVec u = vector_of(field);
    OwnedVec b = tissue->make_vector();
    check(MatMult(a.matrix(), u.get(), b.get()));
    factor.load(b.get());
    // They come in two turns, as a needle goes deeper.
    constexpr std::size_t first = 33;
    const auto of_first = factor.inverse_entries(std::span(rows).first(first), 0);
    const auto of_all = factor.inverse_entries(rows, first);
    expect_near(factor.loaded_rows(0), products(field));
    const auto b_field = products(field);
    const std::vector<double> last(b_field.begin() + first, b_field.end());
    expect_near(factor.loaded_rows(first), last);

    std::vector<double> by_columns(rows.size(), 0.0);
    for (std::size_t j = 0; j < rows.size(); ++j) {
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (j >= first) {
          by_columns[i] += of_all[(j - first) * rows.size() + i] * forces[j];
        } else if (i < first) {
          by_columns[i] += of_first[j * first + i] * forces[j];
        } else {  // symmetric
          by_columns[i] += of_all[(i - first) * rows.size() + j] * forces[j];
        }
      }
    }
    factor.respond_rows(forces, false, x.get());
    expect_near(by_columns, products(solved()));
    check(MatMult(a.matrix(), x.get(), b.get()));
    expect_near(gather_all(b.get()), spread(forces));

    const auto response = solved();
    factor.respond_rows(forces, true, x.get());
    auto sum = field;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += response[i];
    expect_near(solved(), sum);
    factor.unload();
    EXPECT_EQ(factor.loaded_rows(0), std::vector<double>(rows.size(), 0.0));
  }
}

TEST_P(Saddle, TakesNewNumbersAndRefusesAnIndefiniteOperator) {
  factor.factor(a.matrix(), form.matrix());
  constexpr Combination other{3e5, 0.7};
  tissue->make_tangent(other);
  factor.factor(tissue->tangent_matrix(), tissue->saddle(other));
  const OwnedVec u = vector_of(field);
  OwnedVec b = tissue->make_vector();
  check(MatMult(tissue->tangent_matrix(), u.get(), b.get()));
  factor.load(b.get());
  factor.respond({}, {}, true, x.get());
  expect_near(solved(), field);
  constexpr Combination indefinite{-1e7, 1};
  tissue->make_tangent(indefinite);
  EXPECT_THROW(factor.factor(tissue->tangent_matrix(), tissue->saddle(indefinite)), NumericalError);
}

// The compliances of patches, below zero, outweigh everything else on the diagonal.
TEST(SaddleOfSoftTissue, IsFactored) {
  Simulation simulation(
      MPI_COMM_WORLD,
      scene_of(block, {"tissue.regions.outer.youngs_modulus=1e-9 Pa",
                       "tissue.regions.inner.youngs_modulus=1e-9 Pa", "time.method=quasi_static"}),
      true);
  EXPECT_NO_THROW(run_to_end(simulation));
}

}  // namespace
}  // namespace stylet
