// Whether supports leave the tissue a rigid motion.
#include "stylet/scene/check.hpp"
#include "stylet/simulation/conditions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace stylet {

namespace {

[[noreturn]] void refuse(const Scene& scene, const std::string& motion) {
  const std::string why = scene.time.method == TimeMethod::quasi_static
                              ? "without inertia (time.method quasi_static) it has to be held"
                              : "a needle would push it away, and it would not come to rest";
  refuse_key(scene, "supports",
             "nothing keeps the tissue from " + motion + "; " + why +
                 "; allowed: fixed or roller " + (scene.dim() == 2 ? "curves" : "surfaces") +
                 " that hold it");
}

// What the dofs feel of the three translations and of the three turns about the first node, as rows of
// length 6. The rank of all rows is 6 where nothing is free: rows are taken one by one, the one that is
// left longest by those before it first (Gram and Schmidt).
void check_held_in_space(const Scene& scene,
                         const Mesh& mesh,
                         std::span<const PrescribedDof> held) {
  constexpr const char* axes[3] = {"x", "y", "z"};
  std::array<bool, 3> any{};
  for (const auto& c : held) any[static_cast<std::size_t>(c.dof % 3)] = true;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!any[k]) refuse(scene, std::string("moving along ") + axes[k]);
  }
  double size = 0;
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    size = std::max(size, distance(mesh.place(node), mesh.place(0)));
  }
  using Row = std::array<double, 6>;
  std::vector<Row> rows;
  for (const auto& c : held) {
    const auto k = static_cast<std::size_t>(c.dof % 3);
    const auto x = mesh.coordinates(c.dof / 3);
    const auto x0 = mesh.coordinates(0);
    Row row{};
    row[k] = 1;
    // A turn about axis a moves a point along k by the cross product's component.
    const std::size_t next = (k + 1) % 3;
    const std::size_t last = (k + 2) % 3;
    row[3 + next] = (x[last] - x0[last]) / size;
    row[3 + last] = -(x[next] - x0[next]) / size;
    rows.push_back(row);
  }
  const auto product = [](const Row& a, const Row& b) {
    double sum = 0;
    for (std::size_t i = 0; i < 6; ++i) sum += a[i] * b[i];
    return sum;
  };
  constexpr double round_off = 1e-9;
  for (int rank = 0; rank < 6; ++rank) {
    const auto longest =
        std::ranges::max_element(rows, {}, [&](const Row& row) { return product(row, row); });
    const double length = std::sqrt(product(*longest, *longest));
    if (length <= round_off) refuse(scene, "turning");
    Row unit = *longest;
    for (double& entry : unit) entry /= length;
    for (Row& row : rows) {
      const double share = product(row, unit);
      for (std::size_t i = 0; i < 6; ++i) row[i] -= share * unit[i];
    }
  }
}

}  // namespace

void check_held(const Scene& scene, const Mesh& mesh, std::span<const PrescribedDof> held) {
  if (mesh.dim() == 3) {
    check_held_in_space(scene, mesh, held);
    return;
  }
  std::array<std::size_t, 2> n{};
  std::array<double, 2> arm{};  // mean of y over dofs along x, of x over dofs along y
  for (const auto& [dof, value, velocity] : held) {
    const auto component = static_cast<std::size_t>(dof % 2);
    ++n[component];
    arm[component] += mesh.coordinates(dof / 2)[1 - component];
  }
  for (const std::size_t component : {0U, 1U}) {
    if (n[component] == 0) {
      refuse(scene,
             scene.needle_angle == std::numbers::pi
                 ? (component == 0 ? "moving along x" : "moving along y")
                 : (component == 0 ? "moving along the needle" : "moving across the needle"));
    }
    arm[component] /= static_cast<double>(n[component]);
  }
  // Held along both axes, it can turn only about the point that no dof feels.
  double turning = 0;
  double size = 0;
  for (const auto& [dof, value, velocity] : held) {
    const auto component = static_cast<std::size_t>(dof % 2);
    turning =
        std::max(turning, std::abs(mesh.coordinates(dof / 2)[1 - component] - arm[component]));
  }
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    size = std::max(size, distance(mesh.point(node), mesh.point(0)));
  }
  constexpr double round_off = 1e-9;
  if (turning <= round_off * size) refuse(scene, "turning");
}

}  // namespace stylet
