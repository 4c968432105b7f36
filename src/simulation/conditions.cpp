#include "stylet/simulation/conditions.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>

namespace stylet {

namespace {

// A component that a rotation of the scene left as round-off is none.
bool is_zero(double component, double size) {
  constexpr double round_off = 1e-12;
  return std::abs(component) <= round_off * size;
}

double size_of(const PrescribedCurve& p) {
  return std::hypot(p.displacement[0].value_or(0), p.displacement[1].value_or(0));
}

std::vector<std::array<int, 2>> edges_of(const Mesh& mesh, const std::string& curve) {
  std::vector<std::array<int, 2>> edges;
  for (const int f : mesh.facets_of(curve)) {
    const auto at = 2 * static_cast<std::size_t>(f);
    edges.push_back({mesh.data().facets[at], mesh.data().facets[at + 1]});
  }
  return edges;
}

}  // namespace

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
  check_prescribed(mesh);
  check_shared_points(mesh);
  check_tractions(mesh);
}

bool Conditions::is_held(int dof) const {
  return std::ranges::binary_search(held_, dof);
}

void Conditions::check_prescribed(const Mesh& mesh) {
  for (std::size_t i = 0; i < scene_.prescribed.size(); ++i) {
    const auto& p = scene_.prescribed[i];
    std::set<int> corners;
    for (const std::size_t k : {0U, 1U}) {
      if (is_zero(p.displacement[k].value_or(0), size_of(p))) continue;
      const auto held = [&](int node) { return is_held(2 * node + static_cast<int>(k)); };
      for (const auto& [a, b] : edges_of(mesh, p.curve)) {
        if (held(a) && held(b)) {
          refuse_key(scene_, "prescribed." + std::to_string(i) + ".displacement",
                     "would have no effect between " + point_text(scene_, mesh.point(a)) + " and " +
                         point_text(scene_, mesh.point(b)) +
                         ", where a support holds the tissue; allowed: a curve, or a component, "
                         "that is not held");
        }
        for (const int node : {a, b}) {
          if (held(node)) corners.insert(node);
        }
      }
    }
    for (const int node : corners) held_corners_.push_back({i, node});
  }
}

// Points of two prescribed curves have to be given the same history.
void Conditions::check_shared_points(const Mesh& mesh) const {
  std::map<int, std::size_t> first;  // by dof
  for (std::size_t i = 0; i < scene_.prescribed.size(); ++i) {
    const auto& p = scene_.prescribed[i];
    for (const std::size_t k : {0U, 1U}) {
      for (const int dof : curve_dofs_[i][k]) {
        const auto [entry, is_new] = first.emplace(dof, i);
        const auto& q = scene_.prescribed[entry->second];
        if (is_new || is_held(dof)) continue;
        const double by = *p.displacement[k] - *q.displacement[k];
        const bool both_rest = is_zero(*p.displacement[k], size_of(p)) && is_zero(by, size_of(q));
        if (both_rest || (is_zero(by, size_of(p)) && p.start == q.start && p.ramp == q.ramp)) {
          continue;
        }
        refuse_key(scene_, "prescribed." + std::to_string(i) + ".displacement",
                   "moves " + point_text(scene_, mesh.point(dof / 2)) + ", a point of curve '" +
                       q.curve + "' too, in another way than prescribed." +
                       std::to_string(entry->second) +
                       "; allowed: the same displacement, start and ramp there, or null");
      }
    }
  }
}

void Conditions::check_tractions(const Mesh& mesh) const {
  if (scene_.tractions.empty()) return;
  std::set<int> given(held_.begin(), held_.end());
  for (const auto& dofs : curve_dofs_) {
    for (const auto& of_component : dofs) given.insert(of_component.begin(), of_component.end());
  }
  for (std::size_t i = 0; i < scene_.tractions.size(); ++i) {
    const auto& traction = scene_.tractions[i];
    for (const int k : {0, 1}) {
      const double force = k == 0 ? traction.force.x : traction.force.y;
      if (is_zero(force, norm(traction.force))) continue;
      for (const auto& [a, b] : edges_of(mesh, traction.curve)) {
        if (!given.contains(2 * a + k) || !given.contains(2 * b + k)) continue;
        refuse_key(scene_, "loads.traction." + std::to_string(i) + ".force",
                   "would have no effect between " + point_text(scene_, mesh.point(a)) + " and " +
                       point_text(scene_, mesh.point(b)) +
                       ", where a support or a prescribed displacement holds the tissue; allowed: "
                       "a curve that is free to move along the force");
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

bool Conditions::changes(double t0, double t1) const {
  return load_changes(t0, t1) ||
         std::ranges::any_of(scene_.prescribed, [&](const PrescribedCurve& p) {
           return p.start <= t1 && t0 < p.start + p.ramp;
         });
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
    const std::string why = scene.time.method == TimeMethod::quasi_static
                                ? "without inertia (time.method quasi_static) it has to be held"
                                : "a needle would push it away, and it would not come to rest";
    refuse_key(scene, "supports",
               "nothing keeps the tissue from " + motion + "; " + why +
                   "; allowed: fixed or roller "
                   "curves that hold it");
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
