// Needles in space that have no answer, and why.
#include "stylet/base/text.hpp"
#include "stylet/needle/stops.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/space_way.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace stylet {

namespace {

// The point of a triangle that is nearest to p (after Ericson, Real-Time Collision Detection, sec. 5.1.5).
ReferencePlace nearest(const SurfaceTriangle& triangle, ReferencePlace p) {
  const auto& [a, b, c] = triangle;
  const Vector3 ab = b - a;
  const Vector3 ac = c - a;
  const double d1 = dot(ab, p - a);
  const double d2 = dot(ac, p - a);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = dot(ab, p - b);
  const double d4 = dot(ac, p - b);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double d5 = dot(ab, p - c);
  const double d6 = dot(ac, p - c);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

struct Side {
  SurfaceTriangle triangle;
  Vector3 outward = {};   ///< of a free one, of unit length
  std::string held = {};  ///< by what; empty: free
};

std::vector<Side> sides_of(const Scene& scene, const Mesh& mesh) {
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
      const double away = is_skin ? radius : distance(nearest(side.triangle, x), x);
      if (away >= least) continue;
      least = away;
      nearest_side = &side;
    }
    if (nearest_side == nullptr) continue;
    const auto& [triangle, outward, held] = *nearest_side;
    refuse_needle(
        scene, needle, "kernel_radius",
        "comes within " + brief(1e3 * least) + " mm of the tissue's surface at " +
            point_text(scene, nearest(triangle, x)) +
            (held.empty() ? "" : ", which is held (" + held + ")") + ", " + brief(1e3 * depth) +
            " mm behind its entry point; allowed: a kernel_radius smaller than that, or a "
            "way farther from it");
  }
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
    static_cast<void>(make_path(scene, mesh, needle, {}));
  }
}

}  // namespace stylet
