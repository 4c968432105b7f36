// One step in the near field against the equations of the whole tissue, solved densely: dofs and rows of
// many dofs with a dense compliance of their own, given and pushed, beside elements that have changed.
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/simulation/model.hpp"
#include "stylet/solvers/near_field.hpp"

#include "support/scenes.hpp"
#include <gtest/gtest.h>
#include <petscblaslapack.h>

namespace stylet {
namespace {

const std::string slab = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 10, rows: 8, jitter: 0.1}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
supports: {left: fixed}
time: {method: implicit, step: 10 ms, duration: 1 s}
)";

/// Points whose rows are means over patches of dofs, some of them held, which overlap.
class Patches final : public TrackOperator {
 public:
  explicit Patches(int n_dofs) : n_dofs_(n_dofs) {}
  [[nodiscard]] SparseRow row(TrackPlace place) const override {
    SparseRow row;
    constexpr int size = 14;
    for (int k = 0; k < size; ++k) {
      const int dof = (37 * place.point + 2 * k + static_cast<int>(place.component)) % n_dofs_;
      row.push_back({dof, (1 + 0.3 * std::sin(k + place.point)) / size});
    }
    return row;
  }
  /// As Kelvin's solution does it falls off with the distance, and is the same in both directions.
  [[nodiscard]] double rest(TrackPlace a, TrackPlace b) const override {
    if (a.component != b.component) return 0;
    constexpr double size = 2e-4;  // m/N; the tissue's own is about as large
    return size * std::exp(-std::abs(a.point - b.point));
  }

 private:
  int n_dofs_;
};

double size_of_values(const std::vector<double>& values) {
  double size = 0;
  for (const double value : values) size = std::max(size, std::abs(value));
  return size;
}

/// Dense and square, solved by elimination with pivots.
class Dense {
 public:
  explicit Dense(std::size_t n) : n_(n), a_(n * n), b_(n) {}
  double& a(std::size_t i, std::size_t j) { return a_[j * n_ + i]; }
  double& b(std::size_t i) { return b_[i]; }
  std::vector<double> solve() {
    auto n = static_cast<PetscBLASInt>(n_);
    PetscBLASInt one = 1;
    PetscBLASInt info = 0;
    std::vector<PetscBLASInt> pivots(n_);
    LAPACKgesv_(&n, &one, a_.data(), &n, pivots.data(), b_.data(), &n, &info);
    EXPECT_EQ(info, 0);
    return b_;
  }

 private:
  std::size_t n_;
  std::vector<double> a_;
  std::vector<double> b_;
};

struct Problem {
  std::vector<int> coordinates;
  std::vector<int> given;  ///< of coordinates, like the others
  std::vector<int> weighed;
  std::vector<int> pushed;
  std::vector<int> sprung;
  [[nodiscard]] static double value(int i) { return 0.01 * std::cos(i); }
  [[nodiscard]] static double weight(int i) { return 0.3 + 0.1 * std::sin(i); }
  [[nodiscard]] static double force(int i) { return 0.5 * std::sin(1 + i); }
  [[nodiscard]] static double mean() { return 0.02; }
  [[nodiscard]] static double pull(int i) { return 0.4 * std::cos(2 + i); }
  [[nodiscard]] static double stiffness() { return 3e3; }  // about that of the tissue
  double rest = 0;
};

class NearFieldRows : public testing::Test {
 protected:
  NearFieldRows()
      : scene_(scene_of(slab)),
        numbered_(make_mesh(MPI_COMM_WORLD, scene_)),
        tissue_(make_tissue(MPI_COMM_WORLD, scene_, numbered_)),
        n_(tissue_->n_dofs()),
        patches_(n_),
        near_(MPI_COMM_WORLD, n_),
        b_(tissue_->make_vector()) {
    tissue_->make_tangent({1e4, 1});
    for (const int node : numbered_.mesh.nodes_of("left")) {
      held_.push_back({2 * node, 0});
      held_.push_back({2 * node + 1, 0});
    }
    near_.follow(&patches_);
    near_.factor(tissue_->tangent_matrix(), held_);
    check(VecSet(b_.get(), 0));
    for (int dof = 0; dof < n_; ++dof) set_owned(b_.get(), dof, is_held(dof) ? 0 : std::sin(dof));
  }

  [[nodiscard]] bool is_held(int dof) const {
    return std::ranges::find(held_, dof, &PrescribedDof::dof) != held_.end();
  }
  [[nodiscard]] int row(int point, Component component = Component::along) const {
    return coordinate_of(n_, {point, component});
  }

  /// An inner node moves a little.
  void edit() {
    Mesh& mesh = numbered_.mesh;
    int node = mesh.n_nodes() / 2;
    while (mesh.on_boundary(node) || mesh.is_locked(node)) ++node;
    const auto around = mesh.cells_around(node);
    const std::vector<int> cells(around.begin(), around.end());
    mesh.move_node(node, mesh.point(node) + Vector2{2e-4, -1e-4});
    tissue_->update(mesh, cells);
    near_.changed(tissue_->tangent_matrix(), dofs_of(tissue_->rows_of(mesh, cells)));
  }

  /// Row of B of a coordinate.
  [[nodiscard]] SparseRow row_of(int coordinate) const {
    if (coordinate < n_) return {{coordinate, 1.0}};
    return patches_.row(place_of(n_, coordinate));
  }
  [[nodiscard]] double rest(int a, int b) const {
    if (a < n_ || b < n_) return 0;
    return patches_.rest(place_of(n_, a), place_of(n_, b));
  }

  struct Answer {
    std::vector<double> x;  ///< of all dofs
    std::vector<double> q;  ///< of the coordinates
    std::vector<double> f;  ///< on them
    double lambda = 0;
  };

  Answer condensed(const Problem& p) {
    near_.load(b_.get());
    near_.include(p.coordinates);
    const auto at = [&](int i) { return near_.at(p.coordinates[static_cast<std::size_t>(i)]); };
    std::vector<double> extra(near_.coordinates().size(), 0.0);
    for (const int i : p.pushed) extra[at(i)] = Problem::force(i);
    NearField::Demand demand;
    for (const int i : p.given) demand.given.push_back({at(i), Problem::value(i)});
    for (const int i : p.weighed) demand.weights.push_back({at(i), Problem::weight(i)});
    demand.value = Problem::mean();
    demand.rest = p.rest;
    for (const int i : p.sprung) {
      demand.springs.push_back({at(i), Problem::pull(i), Problem::stiffness()});
    }
    auto solution = near_.solve(extra, demand);
    OwnedVec x = tissue_->make_vector();
    OwnedVec left = tissue_->make_vector();
    const auto balance = [&](Vec of, Vec residual) {
      check(MatMult(tissue_->tangent_matrix(), of, residual));
      check(VecAXPY(residual, -1, b_.get()));
      Entries r(residual);
      for (std::size_t i = 0; i < extra.size(); ++i) near_.subtract(i, extra[i], r);
    };
    near_.complete(balance, 1, extra, demand, solution, x.get(), left.get());
    Answer answer;
    answer.x = gather_all(x.get());
    answer.lambda = solution.lambda;
    for (std::size_t i = 0; i < p.coordinates.size(); ++i) {
      const std::size_t k = near_.at(p.coordinates[i]);
      answer.q.push_back(solution.x[k]);
      answer.f.push_back(solution.reaction[k] + extra[k]);
    }
    for (const int i : p.weighed) {
      answer.f[static_cast<std::size_t>(i)] += solution.lambda * Problem::weight(i);
    }
    return answer;
  }

  /// Of A, row by row, on every rank.
  [[nodiscard]] std::vector<double> operator_entries() const {
    const auto n = static_cast<std::size_t>(n_);
    std::vector<double> entries(n * n, 0.0);
    for (int row = tissue_->first_dof(); row < tissue_->end_dof(); ++row) {
      PetscInt size = 0;
      const PetscInt* columns = nullptr;
      const PetscScalar* values = nullptr;
      check(MatGetRow(tissue_->tangent_matrix(), row, &size, &columns, &values));
      for (PetscInt k = 0; k < size; ++k) {
        entries[static_cast<std::size_t>(row) * n + static_cast<std::size_t>(columns[k])] =
            values[k];
      }
      check(MatRestoreRow(tissue_->tangent_matrix(), row, &size, &columns, &values));
    }
    MPI_Allreduce(MPI_IN_PLACE, entries.data(), static_cast<int>(entries.size()), MPI_DOUBLE,
                  MPI_SUM, MPI_COMM_WORLD);
    return entries;
  }

  /// Unknowns x, f and lambda: A x - B^T f = b; given: B x + C f = value; else f = extra + lambda w, and
  /// what springs pull with, less stiffness (B x + C f); w (B x + C f) + rest lambda = mean.
  Answer dense(const Problem& p) {
    const auto n = static_cast<std::size_t>(n_);
    const std::size_t m = p.coordinates.size();
    Dense system(n + m + 1);
    const auto b = gather_all(b_.get());
    const auto a = operator_entries();
    for (std::size_t i = 0; i < n; ++i) {
      const bool free = !is_held(static_cast<int>(i));
      for (std::size_t j = 0; j < n; ++j) system.a(i, j) = free ? a[i * n + j] : 0;
      system.b(i) = b[i];
      if (!free) system.a(i, i) = 1;
    }
    const auto has = [](const std::vector<int>& list, std::size_t i) {
      return std::ranges::find(list, static_cast<int>(i)) != list.end();
    };
    const auto feels = [&](std::size_t equation, std::size_t i, double weight) {
      for (const auto& [dof, value] : row_of(p.coordinates[i])) {
        system.a(equation, static_cast<std::size_t>(dof)) += weight * value;
      }
      for (std::size_t j = 0; j < m; ++j) {
        system.a(equation, n + j) += weight * rest(p.coordinates[i], p.coordinates[j]);
      }
    };
    for (std::size_t i = 0; i < m; ++i) {
      for (const auto& [dof, value] : row_of(p.coordinates[i])) {
        if (!is_held(dof)) system.a(static_cast<std::size_t>(dof), n + i) -= value;
      }
      const int number = static_cast<int>(i);
      if (has(p.given, i)) {
        feels(n + i, i, 1);
        system.b(n + i) = Problem::value(number);
        continue;
      }
      if (has(p.sprung, i)) {
        feels(n + i, i, Problem::stiffness());
        system.b(n + i) = Problem::pull(number);
      }
      system.a(n + i, n + i) += 1;
      if (has(p.pushed, i)) system.b(n + i) += Problem::force(number);
      if (has(p.weighed, i)) system.a(n + i, n + m) = -Problem::weight(number);
    }
    if (p.weighed.empty()) system.a(n + m, n + m) = 1;
    for (const int i : p.weighed) feels(n + m, static_cast<std::size_t>(i), Problem::weight(i));
    if (!p.weighed.empty()) {
      system.b(n + m) = Problem::mean();
      system.a(n + m, n + m) = p.rest;
    }
    const auto all = system.solve();
    const auto from = [&](std::size_t k) { return all.begin() + static_cast<std::ptrdiff_t>(k); };
    Answer answer{{from(0), from(n)}, {}, {from(n), from(n + m)}, all[n + m]};
    for (std::size_t i = 0; i < m; ++i) {
      double q = 0;
      for (const auto& [dof, value] : row_of(p.coordinates[i])) {
        q += value * answer.x[static_cast<std::size_t>(dof)];
      }
      for (std::size_t j = 0; j < m; ++j) {
        q += rest(p.coordinates[i], p.coordinates[j]) * answer.f[j];
      }
      answer.q.push_back(q);
    }
    return answer;
  }

  void expect_same(const Problem& p) {
    const Answer near = condensed(p);
    const Answer whole = dense(p);
    const auto compare = [](const std::vector<double>& a, const std::vector<double>& b) {
      ASSERT_EQ(a.size(), b.size());
      // Round-off times the conditions of both systems, some 1e3.
      const double tolerance = 1e-11 * size_of_values(b);
      for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], tolerance) << i;
    };
    compare(near.x, whole.x);
    compare(near.q, whole.q);
    compare(near.f, whole.f);
    compare({near.lambda}, {whole.lambda});
  }

  Scene scene_;
  NumberedMesh numbered_;
  std::unique_ptr<TissueOperator> tissue_;
  int n_;
  Patches patches_;
  NearField near_;
  OwnedVec b_;
  std::vector<PrescribedDof> held_;
};

TEST_F(NearFieldRows, DofsAlone) {
  edit();
  expect_same({{n_ / 2, n_ / 3, n_ / 4, n_ / 5}, {0, 1}, {2, 3}, {}, {}});
}

TEST_F(NearFieldRows, RowsWithTheirOwnCompliance) {
  expect_same({{row(0), row(1), row(1, Component::across), row(2), row(3), row(4)},
               {0, 1, 2},
               {},
               {4},
               {}});
}

TEST_F(NearFieldRows, TheMeanOfRowsIsGivenWhileOthersAreHeldAndPushed) {
  expect_same({{row(0), row(1), row(2), row(3), row(4)}, {0, 1}, {2, 3}, {4}, {}});
}

TEST_F(NearFieldRows, TheMeanHasARestOfItsOwn) {
  expect_same({{row(0), row(1), row(2), row(3), row(4)}, {0, 1}, {2, 3}, {4}, {}, 3e-4});
}

TEST_F(NearFieldRows, SpringsPullAtRowsAndDofs) {
  const std::vector<int> coordinates{row(0), row(1), row(2), n_ / 2, n_ / 3, row(3)};
  expect_same({coordinates, {0}, {1, 2}, {2}, {1, 3, 5}});
  // Other ones, at the same factor.
  expect_same({coordinates, {0}, {1, 2}, {2}, {4}});
  expect_same({coordinates, {0}, {1, 2}, {2}, {}});
}

// Rows that come later border those that are there, and all come again with a new factor.
TEST_F(NearFieldRows, RowsBesideDofsAndElementsThatHaveChanged) {
  const Problem first{{row(0), row(1)}, {0}, {}, {1}, {}};
  const Problem all{{row(0), row(1), n_ / 2, row(2), n_ / 4, row(3, Component::across)},
                    {0, 2},
                    {1, 3},
                    {4, 5},
                    {1, 5}};
  expect_same(first);
  edit();
  expect_same(first);
  expect_same(all);
  near_.factor(tissue_->tangent_matrix(), held_);
  expect_same(all);
}

}  // namespace
}  // namespace stylet
