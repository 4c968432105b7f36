#include "stylet/simulation/conditions.hpp"

#include "stylet/base/errors.hpp"

#include <algorithm>
#include <map>
#include <set>

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

}  // namespace stylet
