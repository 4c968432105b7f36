#include "stylet/simulation/conditions.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/index.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
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
  double size = 0;
  for (const auto& component : p.displacement) size = std::hypot(size, component.value_or(0));
  return size;
}

/// 'between A and B', or the three corners of a triangle.
std::string between(const Scene& scene, const Mesh& mesh, std::span<const int> facet) {
  std::string text = "between " + point_text(scene, mesh.place(facet[0]));
  for (std::size_t i = 1; i < facet.size(); ++i) {
    text += (i + 1 < facet.size() ? ", " : " and ") + point_text(scene, mesh.place(facet[i]));
  }
  return text;
}

/// The axis that a facet is normal to, or none.
std::optional<int> normal_axis(const Mesh& mesh, std::span<const int> facet) {
  constexpr double parallel = 1e-9;
  const auto x0 = mesh.coordinates(facet[0]);
  std::array<double, 3> spread{};
  double extent = 0;
  for (const int node : facet) {
    const auto x = mesh.coordinates(node);
    double length = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
      spread[k] = std::max(spread[k], std::abs(x[k] - x0[k]));
      length = std::hypot(length, x[k] - x0[k]);
    }
    extent = std::max(extent, length);
  }
  for (int k = mesh.dim() - 1; k >= 0; --k) {
    if (spread[static_cast<std::size_t>(k)] <= parallel * extent) return k;
  }
  return std::nullopt;
}

}  // namespace

Conditions::Conditions(const Scene& scene, const Mesh& mesh) : scene_(scene), dim_(mesh.dim()) {
  std::set<int> held;
  for (const auto& support : scene.supports) {
    if (support.kind == SupportKind::free) continue;
    for (const int f : mesh.facets_of(support.curve)) {
      const auto facet = mesh.facet(f);
      const auto nodes = mesh.facet_nodes(f);
      if (support.kind == SupportKind::fixed) {
        for (const int node : nodes) {
          for (int k = 0; k < dim_; ++k) held.insert(dim_ * node + k);
        }
        continue;
      }
      const auto axis = normal_axis(mesh, facet);
      if (!axis) {
        throw InputError(scene.file + ": key 'supports." + support.curve + "': roller needs a " +
                         (dim_ == 2 ? "boundary along or across the needle (x or y)"
                                    : "surface that is normal to x, y or z"));
      }
      for (const int node : nodes) held.insert(dim_ * node + *axis);
    }
  }
  held_.assign(held.begin(), held.end());
  for (const auto& prescribed : scene.prescribed) {
    auto& dofs = curve_dofs_.emplace_back();
    for (const int node : mesh.nodes_of(prescribed.curve)) {
      for (std::size_t k = 0; k < prescribed.displacement.size(); ++k) {
        if (prescribed.displacement[k]) dofs[k].push_back(dim_ * node + static_cast<int>(k));
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
    for (std::size_t k = 0; k < p.displacement.size(); ++k) {
      if (is_zero(p.displacement[k].value_or(0), size_of(p))) continue;
      const auto held = [&](int node) { return is_held(dim_ * node + static_cast<int>(k)); };
      for (const int f : mesh.facets_of(p.curve)) {
        const auto facet = mesh.facet(f);
        const auto nodes = mesh.facet_nodes(f);
        if (std::ranges::all_of(nodes, held)) {
          refuse_key(scene_, "prescribed." + std::to_string(i) + ".displacement",
                     "would have no effect " + between(scene_, mesh, facet) +
                         ", where a support holds the tissue; allowed: a " +
                         (dim_ == 2 ? "curve" : "surface") + ", or a component, that is not held");
        }
        for (const int node : nodes) {
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
    for (std::size_t k = 0; k < p.displacement.size(); ++k) {
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
                   "moves " + point_text(scene_, mesh.place(dof / dim_)) + ", a point of " +
                       (dim_ == 2 ? "curve '" : "surface '") + q.curve +
                       "' too, in another way than prescribed." + std::to_string(entry->second) +
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
    const Vector3 force = traction.force.vector();
    for (int k = 0; k < dim_; ++k) {
      if (is_zero(component(force, static_cast<std::size_t>(k)), norm(force))) continue;
      const auto is_given = [&](int node) { return given.contains(dim_ * node + k); };
      for (const int f : mesh.facets_of(traction.curve)) {
        const auto facet = mesh.facet(f);
        if (!std::ranges::all_of(mesh.facet_nodes(f), is_given)) continue;
        refuse_key(scene_,
                   "loads.traction." + std::to_string(i) + (dim_ == 2 ? ".force" : ".stress"),
                   "would have no effect " + between(scene_, mesh, facet) +
                       ", where a support or a prescribed displacement holds the tissue; allowed: "
                       "a " +
                       (dim_ == 2 ? "curve" : "surface") + " that is free to move along the force");
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
    for (std::size_t k = 0; k < p.displacement.size(); ++k) {
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
  const auto dim = static_cast<std::size_t>(dim_);
  std::vector<double> force(dim * static_cast<std::size_t>(mesh.n_nodes()), 0.0);
  const auto add = [&](int node, double share, const Components& f) {
    double* const of_node = &force[dim * static_cast<std::size_t>(node)];
    of_node[0] += share * f.x;
    of_node[1] += share * f.y;
    if (dim == 3) of_node[2] += share * *f.z;
  };
  // Constant over a cell or facet. Of quadratic shape functions those of a tetrahedron's corners have the
  // mean -1/20, those of its edges 1/5; of a triangle's 0 and 1/3.
  const auto spread = [&](std::span<const int> nodes, int n_corners, double size,
                          const Components& f) {
    const bool quadratic = nodes.size() > at(n_corners);
    const double linear_share = size / n_corners;
    const double at_corner = !quadratic ? linear_share : n_corners == 4 ? -size / 20 : 0;
    const double at_edge = n_corners == 4 ? size / 5 : size / 3;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      add(nodes[k], k < at(n_corners) ? at_corner : at_edge, f);
    }
  };
  for (const auto& body : scene_.body_forces) {
    if (t < body.start) continue;
    for (int c = 0; c < mesh.n_cells(); ++c) {
      spread(mesh.nodes(c), dim_ + 1, mesh.cell_measure(c) * scene_.tissue.depth(), body.force);
    }
  }
  for (const auto& traction : scene_.tractions) {
    if (t < traction.start) continue;
    for (const int f : mesh.facets_of(traction.curve)) {
      spread(mesh.facet_nodes(f), dim_, mesh.facet_measure(f), traction.force);
    }
  }
  return force;
}

}  // namespace stylet
