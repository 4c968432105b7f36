// Needles in space that have no answer, and why.
#include "stylet/base/text.hpp"
#include "stylet/mesh/embedded_point.hpp"
#include "stylet/needle/stops.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/space_way.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace stylet {

namespace {

struct Side {
  SurfaceTriangle triangle;
  Vector3 outward = {};   ///< of a free one, of unit length
  std::string held = {};  ///< by what; empty: free
};

std::vector<Side> held_sides(const Scene& scene, const Mesh& mesh) {
  std::vector<Side> sides;
  const auto add_held = [&](const std::string& surface, const std::string& by) {
    for (const int f : mesh.facets_of(surface)) {
      const auto n = mesh.facet(f);
      sides.push_back({{mesh.place(n[0]), mesh.place(n[1]), mesh.place(n[2])}, {}, by});
    }
  };
  for (const Support& support : scene.supports) {
    if (support.kind != SupportKind::free) add_held(support.curve, "supports." + support.curve);
  }
  for (const PrescribedCurve& prescribed : scene.prescribed) {
    add_held(prescribed.curve, "prescribed, surface '" + prescribed.curve + "'");
  }
  return sides;
}

std::vector<Side> sides_of(const Scene& scene, const Mesh& mesh) {
  std::vector<Side> sides = held_sides(scene, mesh);
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto n = mesh.cell(c);
    if (std::ranges::count_if(n, [&](int node) { return mesh.on_boundary(node); }) < 3) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      if (mesh.beyond(c, k)) continue;
      const auto corner = [&](std::size_t i) { return mesh.place(n[(k + i) % 4]); };
      const Vector3 normal = cross(corner(2) - corner(1), corner(3) - corner(1));
      const double inside = dot(normal, corner(0) - corner(1));
      sides.push_back(
          {{corner(1), corner(2), corner(3)}, (inside > 0 ? -1 : 1) / norm(normal) * normal});
    }
  }
  return sides;
}

// Of the skin's normal: a needle that grazes the skin has half of its kernel outside for long.
void check_angle(const Scene& scene,
                 const std::vector<Side>& sides,
                 const NeedleParameters& needle,
                 const NeedlePath& path) {
  constexpr double most = 70;  // degrees
  const Side* entered = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const Side& side : sides) {
    if (!side.held.empty()) continue;
    const double away = distance(nearest_point(side.triangle, path.skin_point), path.skin_point);
    // Of several that meet there the one that the needle goes through most straight.
    const double facing = -dot(side.outward, path.direction);
    const double cost = away - 1e-6 * facing;
    if (cost >= least) continue;
    least = cost;
    entered = &side;
  }
  const double angle = 180 / std::numbers::pi *
                       std::acos(std::clamp(-dot(entered->outward, path.direction), -1.0, 1.0));
  if (angle <= most) return;
  refuse_needle(scene, needle, needle.space.target ? "target" : "direction",
                "enters " + brief(angle) + " degrees from the normal of the skin at " +
                    point_text(scene, path.skin_point) + "; allowed: up to 70 degrees");
}

// The near field is that of a wide body, but for the free skin around the entry.
void check_distances(const Scene& scene,
                     const std::vector<Side>& sides,
                     const NeedleParameters& needle,
                     const NeedlePath& path) {
  const double radius = needle.space.kernel_radius;
  constexpr int paces = 8;          // a radius
  constexpr double facing = -0.26;  // 75 degrees: skin that the needle comes through
  const int n = static_cast<int>(paces * path.deepest / radius) + 1;
  for (int i = 0; i <= n; ++i) {
    const double depth = path.deepest * i / n;
    const ReferencePlace x = path.skin_point + depth * path.direction;
    const Side* nearest_side = nullptr;
    double least = radius;
    for (const Side& side : sides) {
      const bool is_skin =
          side.held.empty() && depth < 2 * radius && dot(side.outward, path.direction) < facing;
      const double away = is_skin ? radius : distance(nearest_point(side.triangle, x), x);
      if (away >= least) continue;
      least = away;
      nearest_side = &side;
    }
    if (nearest_side == nullptr) continue;
    const auto& [triangle, outward, held] = *nearest_side;
    refuse_needle(scene, needle, "kernel_radius",
                  "comes within " + brief(1e3 * least) + " mm of the tissue's surface at " +
                      point_text(scene, nearest_point(triangle, x)) +
                      (held.empty() ? "" : ", which is held (" + held + ")") + ", " +
                      brief(1e3 * depth) + " mm behind its entry point; allowed: " +
                      (depth == 0 ? "an entry farther than kernel_radius from other sides"
                                  : "a kernel_radius smaller than that, or a way farther from it"));
  }
}

// What the mesh cannot carry has no meaning beside what the kernel leaves out.
void check_elements(const Scene& scene,
                    const Mesh& mesh,
                    const NeedleParameters& needle,
                    const NeedlePath& path) {
  constexpr double widest = 2.5;  // element of a kernel's radius; 4 % of the drag is lost at 1
  const double radius = needle.space.kernel_radius;
  double largest = 0;
  int cell = 0;
  for (double depth = radius / 2; depth < path.deepest; depth += radius / 2) {
    const auto found = locate(mesh, path.skin_point + depth * path.direction, cell);
    if (!found) continue;
    cell = found->cell;
    largest = std::max(largest, std::cbrt(6 * mesh.cell_measure(cell)));
  }
  if (largest <= widest * radius) return;
  refuse_needle(scene, needle, "kernel_radius",
                "leads through elements of " + brief(1e3 * largest) +
                    " mm, which cannot carry a force over a disc of " + brief(1e3 * radius) +
                    " mm; allowed: at least " + brief(1e3 * largest / widest) +
                    " mm, better twice the elements, or a finer mesh");
}

// A tip that is not in would push with all of its force on a point.
void check_membrane(const Scene& scene,
                    const Mesh& mesh,
                    const NeedleParameters& needle,
                    const NeedlePath& path) {
  const double least = needle.cutting.tip_length / 3;
  const auto met = surface_crossings(membrane_surface(scene, mesh), path.skin_point, path.direction,
                                     path.deepest);
  if (met.empty() || met.front() >= least) return;
  refuse_key(scene, "membrane",
             "needle '" + needle.name + "' meets it " + brief(1e3 * met.front()) +
                 " mm behind its entry point; allowed: deeper than a third of its tip_length, " +
                 brief(1e3 * least) + " mm");
}

}  // namespace

void check_ways(const Scene& scene, const Mesh& mesh) {
  static_cast<void>(membrane_surface(scene, mesh));
  if (scene.needles.empty()) return;
  const auto sides = sides_of(scene, mesh);
  for (std::size_t i = 0; i < scene.needles.size(); ++i) {
    const NeedleParameters& needle = scene.needles[i];
    const NeedlePath path = find_way(scene, mesh, needle);
    if (const auto fault = find_fault(needle.motion, 1, 0, true)) {
      refuse_needle(scene, needle, "motion." + std::to_string(fault->action),
                    "enters at " + point_text(scene, path.skin_point) + ": " + fault->reason);
    }
    check_angle(scene, sides, needle, path);
    if (path.deepest >= path.end) {
      refuse_needle(scene, needle, "motion",
                    "goes " + brief(path.deepest) + " m deep, and its way leaves the tissue " +
                        brief(path.end) +
                        " m behind the entry point; allowed: a way inside the "
                        "tissue");
    }
    if (needle.cutting.tip_length > path.end) {
      refuse_needle(scene, needle, "cutting.tip_length",
                    "has a tip that is longer than its way through the tissue, " + brief(path.end) +
                        " m; allowed: a tip that can be in with all of its length");
    }
    constexpr double most_segments = 1000;  // dense matrices have three rows for each
    if (path.deepest > most_segments * needle.space.segment) {
      refuse_needle(scene, needle, "segment",
                    "goes " + brief(path.deepest) + " m deep; allowed: segments of at least " +
                        brief(path.deepest / most_segments) + " m");
    }
    check_membrane(scene, mesh, needle, path);
    check_distances(scene, sides, needle, path);
    check_elements(scene, mesh, needle, path);
    static_cast<void>(make_path(scene, mesh, needle, {}));
  }
}

double distance_to_held(const Scene& scene,
                        const Mesh& mesh,
                        const NeedleParameters& needle,
                        const NeedlePath& path) {
  const auto sides = held_sides(scene, mesh);
  double least = std::numeric_limits<double>::infinity();
  const int n = static_cast<int>(8 * path.deepest / needle.space.kernel_radius) + 1;
  for (int i = 0; i <= n; ++i) {
    const ReferencePlace x = path.skin_point + path.deepest * i / n * path.direction;
    for (const Side& side : sides) {
      least = std::min(least, distance(nearest_point(side.triangle, x), x));
    }
  }
  return least;
}

}  // namespace stylet
