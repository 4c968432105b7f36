// Supports, prescribed curves and loads of a scene, at any time.
#pragma once

#include "stylet/dynamics/constraint_set.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/scene/scene.hpp"

#include <span>
#include <vector>

namespace stylet {

class Conditions {
 public:
  /// Throws InputError for a roller on a boundary that is not parallel to an axis.
  Conditions(const Scene& scene, const Mesh& mesh);

  /// Prescribed dofs at time t, by ascending dof.
  [[nodiscard]] std::vector<PrescribedDof> prescribed(double t) const;
  /// True if the loads differ between the two times.
  [[nodiscard]] bool load_changes(double t0, double t1) const;
  /// Nodal forces (N) at time t, dof = 2 node + component, all nodes. Empty if there is no load.
  [[nodiscard]] std::vector<double> load(const Mesh& mesh, double t) const;
  [[nodiscard]] bool has_body_force() const { return !scene_.body_forces.empty(); }
  [[nodiscard]] bool has_load() const { return has_body_force() || !scene_.tractions.empty(); }

  /// Dofs of a prescribed curve (index into Scene::prescribed), by component.
  [[nodiscard]] std::span<const int> curve_dofs(std::size_t curve, std::size_t component) const {
    return curve_dofs_[curve][component];
  }

 private:
  const Scene& scene_;
  std::vector<int> held_;  ///< dofs of supports, ascending
  std::vector<std::array<std::vector<int>, 2>> curve_dofs_;
};

/// Throws InputError that names a rigid motion which these dofs leave free: without inertia nothing
/// else resists it.
void check_held(const Scene& scene, const Mesh& mesh, std::span<const PrescribedDof> held);

}  // namespace stylet
