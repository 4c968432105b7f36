#include "stylet/simulation/conditions.hpp"

#include "stylet/base/errors.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>

namespace stylet {

Conditions::Conditions(const Scene& scene, const Mesh& mesh) : scene_(scene) {
  std::set<int> held;
  for (const auto& support : scene.supports) {
    if (support.kind == SupportKind::free) continue;
    for (const int f : mesh.facets_of(support.curve)) {
      const int a = mesh.data().facets[2 * static_cast<std::size_t>(f)];
      const int b = mesh.data().facets[2 * static_cast<std::size_t>(f) + 1];
      const Vector2 edge = mesh.point(b) - mesh.point(a);
      constexpr double parallel = 1e-9;
      const bool along_x = std::abs(edge.y) <= parallel * norm(edge);
      const bool along_y = std::abs(edge.x) <= parallel * norm(edge);
      for (const int node : {a, b}) {
        if (support.kind == SupportKind::fixed) {
          held.insert(2 * node);
          held.insert(2 * node + 1);
        } else if (along_x) {
          held.insert(2 * node + 1);
        } else if (along_y) {
          held.insert(2 * node);
        } else {
          throw InputError(scene.file + ": key 'supports." + support.curve +
                           "': roller needs a boundary along or across the needle (x or y)");
        }
      }
    }
  }
  held_.assign(held.begin(), held.end());
  for (const auto& prescribed : scene.prescribed) {
    auto& dofs = curve_dofs_.emplace_back();
    for (const int node : mesh.nodes_of(prescribed.curve)) {
      for (std::size_t k = 0; k < 2; ++k) {
        if (prescribed.displacement[k]) dofs[k].push_back(2 * node + static_cast<int>(k));
      }
    }
  }
}

std::vector<PrescribedDof> Conditions::prescribed(double t) const {
  if (scene_.prescribed.empty()) {
    std::vector<PrescribedDof> dofs;
    dofs.reserve(held_.size());
    for (const int dof : held_) dofs.push_back({dof, 0.0});
    return dofs;
  }
  std::map<int, double> values;
  for (std::size_t i = 0; i < curve_dofs_.size(); ++i) {
    const auto& p = scene_.prescribed[i];
    double share = t > p.start || (p.ramp == 0 && t >= p.start) ? 1 : 0;
    if (share > 0 && p.ramp > 0) share = std::min(1.0, (t - p.start) / p.ramp);
    for (std::size_t k = 0; k < 2; ++k) {
      for (const int dof : curve_dofs_[i][k]) values[dof] = share * *p.displacement[k];
    }
  }
  // Where a support and a prescribed curve meet, the support holds.
  for (const int dof : held_) values[dof] = 0;
  std::vector<PrescribedDof> dofs;
  dofs.reserve(values.size());
  for (const auto& [dof, value] : values) dofs.push_back({dof, value});
  return dofs;
}

bool Conditions::load_changes(double t0, double t1) const {
  const auto between = [&](const auto& load) { return load.start > t0 && load.start <= t1; };
  return std::ranges::any_of(scene_.body_forces, between) ||
         std::ranges::any_of(scene_.tractions, between);
}

std::vector<double> Conditions::load(const Mesh& mesh, double t) const {
  if (!has_load()) return {};
  std::vector<double> force(2 * static_cast<std::size_t>(mesh.n_nodes()), 0.0);
  const auto add = [&](int node, double share, Vector2 f) {
    force[2 * static_cast<std::size_t>(node)] += share * f.x;
    force[2 * static_cast<std::size_t>(node) + 1] += share * f.y;
  };
  for (const auto& body : scene_.body_forces) {
    if (t < body.start) continue;
    for (int c = 0; c < mesh.n_cells(); ++c) {
      const double share = mesh.cell_measure(c) * scene_.tissue.thickness / 3;
      for (const int node : mesh.cell(c)) add(node, share, body.force);
    }
  }
  for (const auto& traction : scene_.tractions) {
    if (t < traction.start) continue;
    for (const int f : mesh.facets_of(traction.curve)) {
      const int a = mesh.data().facets[2 * static_cast<std::size_t>(f)];
      const int b = mesh.data().facets[2 * static_cast<std::size_t>(f) + 1];
      const double share = 0.5 * distance(mesh.point(a), mesh.point(b));
      add(a, share, traction.force);
      add(b, share, traction.force);
    }
  }
  return force;
}

void check_held(const Scene& scene, const Mesh& mesh, std::span<const PrescribedDof> held) {
  std::array<std::size_t, 2> n{};
  std::array<double, 2> arm{};  // mean of y over dofs along x, of x over dofs along y
  for (const auto& [dof, value, velocity] : held) {
    const auto component = static_cast<std::size_t>(dof % 2);
    ++n[component];
    arm[component] += mesh.coordinates(dof / 2)[1 - component];
  }
  const auto refuse = [&](const std::string& motion) {
    throw InputError(scene.file + ": key 'supports': nothing keeps the tissue from " + motion +
                     "; without inertia (time.method quasi_static) it has to be held: fixed or "
                     "roller");
  };
  for (const std::size_t component : {0U, 1U}) {
    if (n[component] == 0) {
      refuse(scene.needle_angle == std::numbers::pi
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
  if (turning <= round_off * size) refuse("turning");
}

}  // namespace stylet
