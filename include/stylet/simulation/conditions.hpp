// Supports, prescribed curves (surfaces in space) and loads of a scene, at any time.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/scene/scene.hpp"
#include "stylet/solvers/constraint_set.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace stylet {

/// A point of a prescribed curve that a support holds.
struct HeldCorner {
  std::size_t prescribed = 0;  ///< index into Scene::prescribed
  int node = -1;
};

class Conditions {
 public:
  /// Throws InputError for a roller on a boundary that is not parallel to an axis, and for a
  /// displacement or a traction that would have no effect, or two, along an edge or at a point.
  Conditions(const Scene& scene, const Mesh& mesh);

  /// Prescribed dofs at time t, by ascending dof.
  [[nodiscard]] std::vector<PrescribedDof> prescribed(double t) const;
  /// True if the loads differ between the two times.
  [[nodiscard]] bool load_changes(double t0, double t1) const;
  /// True if loads or prescribed displacements are not the same from t0 on to t1.
  [[nodiscard]] bool changes(double t0, double t1) const;
  /// Nodal forces (N) at time t, dof = dim node + component, all nodes. Empty if there is no load.
  [[nodiscard]] std::vector<double> load(const Mesh& mesh, double t) const;
  [[nodiscard]] bool has_body_force() const { return !scene_.body_forces.empty(); }
  [[nodiscard]] bool has_load() const { return has_body_force() || !scene_.tractions.empty(); }

  /// Dofs of a prescribed curve (index into Scene::prescribed), by component.
  [[nodiscard]] std::span<const int> curve_dofs(std::size_t curve, std::size_t component) const {
    return curve_dofs_[curve][component];
  }

  /// Where a support and a prescribed curve meet in a point, the support holds.
  [[nodiscard]] const std::vector<HeldCorner>& held_corners() const { return held_corners_; }

 private:
  void check_prescribed(const Mesh& mesh);
  void check_shared_points(const Mesh& mesh) const;
  void check_tractions(const Mesh& mesh) const;
  [[nodiscard]] bool is_held(int dof) const;

  const Scene& scene_;
  int dim_;
  std::vector<int> held_;  ///< dofs of supports, ascending
  std::vector<std::array<std::vector<int>, 3>> curve_dofs_;
  std::vector<HeldCorner> held_corners_;
};

/// Throws InputError that names a rigid motion which these dofs leave free: without inertia nothing
/// else resists it.
void check_held(const Scene& scene, const Mesh& mesh, std::span<const PrescribedDof> held);

}  // namespace stylet
