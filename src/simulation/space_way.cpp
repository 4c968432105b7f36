#include "stylet/simulation/space_way.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/mesh/embedded_point.hpp"
#include "stylet/mesh/line_through.hpp"
#include "stylet/needle/stops.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace stylet {

namespace {

struct Line {
  ReferencePlace start;
  Vector3 direction;
};

Line line_of(const NeedleParameters& needle) {
  const SpaceParameters& space = needle.space;
  const ReferencePlace start = space.entry->place();
  const Vector3 way = space.target ? space.target->place() - start : space.direction->vector();
  return {start, 1 / norm(way) * way};
}

/// Sides of the tissue that come nearer to x than `radius`.
std::vector<SurfaceTriangle> sides_near(const Mesh& mesh, ReferencePlace x, double radius) {
  std::vector<SurfaceTriangle> sides;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto n = mesh.cell(c);
    if (std::ranges::count_if(n, [&](int node) { return mesh.on_boundary(node); }) < 3) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto corner = [&](std::size_t i) { return mesh.place(n[(k + i) % 4]); };
      const SurfaceTriangle side{corner(1), corner(2), corner(3)};
      if (distance(nearest_point(side, x), x) < radius && !mesh.beyond(c, k)) sides.push_back(side);
    }
  }
  return sides;
}

}  // namespace

void refuse_needle(const Scene& scene,
                   const NeedleParameters& needle,
                   const std::string& key,
                   const std::string& why) {
  const auto same = std::ranges::find(scene.needles, needle.name, &NeedleParameters::name);
  const auto index = std::to_string(same - scene.needles.begin());
  refuse_key(scene, "needles." + index + "." + key, "needle '" + needle.name + "' " + why);
}

NeedlePath find_way(const Scene& scene, const Mesh& mesh, const NeedleParameters& needle) {
  const Line line = line_of(needle);
  constexpr double on_skin = 1e-7;  // m
  if (locate(mesh, line.start + -on_skin * line.direction)) {
    refuse_needle(scene, needle, "entry",
                  "begins inside the tissue, at " + point_text(scene, line.start) +
                      "; allowed: a point on the skin, or in front of it");
  }
  const auto stretch = first_stretch(mesh, line.start, line.direction);
  if (!stretch) {
    refuse_needle(scene, needle, needle.space.target ? "target" : "direction",
                  "misses the tissue; allowed: a line from entry that leads through it");
  }
  NeedlePath path;
  path.skin_point = line.start + stretch->from * line.direction;
  path.direction = line.direction;
  path.end = stretch->to - stretch->from;
  for (const Travel& travel : travels_of(needle.motion, 1)) {
    path.deepest = std::max(path.deepest, along_of(travel.to, 0));
  }
  // Regions are told to a fifth of a millimetre.
  constexpr double pace = 0.2e-3;
  const double to = std::min(path.deepest, path.end);
  const int n = std::max(1, static_cast<int>(std::ceil(to / pace)));
  int cell = stretch->cell;
  for (int i = 0; i < n; ++i) {
    const auto found = locate(mesh, path.skin_point + ((i + 0.5) / n * to) * path.direction, cell);
    if (!found) continue;
    cell = found->cell;
    const auto& region = mesh.data().region_names[static_cast<std::size_t>(mesh.region(cell))];
    if (path.pieces.empty() || path.pieces.back().region != region) {
      path.pieces.push_back({region, i * to / n, 0});
    }
    path.pieces.back().to = (i + 1) * to / n;
  }
  return path;
}

std::vector<SurfaceTriangle> membrane_surface(const Scene& scene, const Mesh& mesh) {
  std::vector<SurfaceTriangle> surface;
  if (!scene.membrane) return surface;
  std::map<std::array<int, 2>, int> edges;
  const auto add = [&](std::array<int, 3> nodes) {
    surface.push_back({mesh.place(nodes[0]), mesh.place(nodes[1]), mesh.place(nodes[2])});
    std::ranges::sort(nodes);
    ++edges[{nodes[0], nodes[1]}];
    ++edges[{nodes[0], nodes[2]}];
    ++edges[{nodes[1], nodes[2]}];
  };
  const MembraneParameters& membrane = *scene.membrane;
  if (!membrane.surface.empty()) {
    for (const int f : mesh.facets_of(membrane.surface)) {
      const auto n = mesh.facet(f);
      add({n[0], n[1], n[2]});
    }
  } else {
    const int region = mesh.region_index(membrane.region);
    for (int c = 0; c < mesh.n_cells(); ++c) {
      if (mesh.region(c) != region) continue;
      const auto n = mesh.cell(c);
      for (std::size_t k = 0; k < 4; ++k) {
        const auto other = mesh.beyond(c, k);
        if (other && mesh.region(*other) == region) continue;
        add({n[(k + 1) % 4], n[(k + 2) % 4], n[(k + 3) % 4]});
      }
    }
  }
  const auto is_open = [](const auto& edge) { return edge.second % 2 != 0; };
  if (const auto open = std::ranges::count_if(edges, is_open); open > 0) {
    const auto first = std::ranges::find_if(edges, is_open)->first;
    refuse_key(scene, membrane.surface.empty() ? "membrane.region" : "membrane.surface",
               "the surface is not closed: " + std::to_string(open) +
                   " of its edges end it, one of them at " +
                   point_text(scene, mesh.place(first[0])) + "; allowed: a closed surface");
  }
  return surface;
}

// Mindlin's image is that of a plane, and right for needles up to 40 degrees from its normal.
bool has_plane_skin(const Mesh& mesh, const NeedleParameters& needle, const NeedlePath& path) {
  const double radius = needle.space.kernel_radius;
  constexpr double flat = 0.02;  // of the radius
  constexpr double least_cosine = 0.76;
  const auto sides = sides_near(mesh, path.skin_point, radius);
  const auto away = [&](const SurfaceTriangle& side) {
    return distance(nearest_point(side, path.skin_point), path.skin_point);
  };
  const auto entered = std::ranges::min_element(sides, {}, away);
  if (entered == sides.end()) return false;
  const auto& [a, b, c] = *entered;
  const Vector3 across = cross(b - a, c - a);
  const Vector3 normal = 1 / norm(across) * across;
  if (std::abs(dot(normal, path.direction)) < least_cosine) return false;
  return std::ranges::all_of(sides, [&](const SurfaceTriangle& side) {
    return std::ranges::all_of(side, [&](ReferencePlace x) {
      return std::abs(dot(x - path.skin_point, normal)) < flat * radius;
    });
  });
}

double share_in_other_tissue(const Scene& scene,
                             const Mesh& mesh,
                             const NeedleParameters& needle,
                             const NeedlePath& path) {
  constexpr double alike = 1.1;  // moduli
  constexpr int around = 12;
  const double radius = needle.space.kernel_radius;
  std::vector<double> modulus(mesh.data().region_names.size());
  for (const auto& [region, material] : scene.tissue.regions) {
    modulus[static_cast<std::size_t>(mesh.region_index(region))] = material.youngs_modulus;
  }
  const auto modulus_at = [&](ReferencePlace x, int& cell) -> std::optional<double> {
    const auto found = locate(mesh, x, cell);
    if (!found) return std::nullopt;
    cell = found->cell;
    return modulus[static_cast<std::size_t>(mesh.region(cell))];
  };
  const auto [across, across_too] = across_of(path.direction);
  int cell = 0;
  int n = 0;
  int n_other = 0;
  for (double depth = radius / 8; depth < path.deepest; depth += radius / 4) {
    const ReferencePlace centre = path.skin_point + depth * path.direction;
    const auto own = modulus_at(centre, cell);
    if (!own) continue;
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * std::numbers::pi * k / around;
      const auto other = modulus_at(
          centre + radius * std::cos(angle) * across + radius * std::sin(angle) * across_too, cell);
      if (!other) continue;
      ++n;
      n_other += std::max(*other / *own, *own / *other) > alike ? 1 : 0;
    }
  }
  return n == 0 ? 0 : static_cast<double>(n_other) / n;
}

std::unique_ptr<EmbeddedPath> make_path(const Scene& scene,
                                        const Mesh& mesh,
                                        const NeedleParameters& needle,
                                        NeedleTissue tissue) {
  const NeedlePath path = find_way(scene, mesh, needle);
  const double radius = needle.diameter / 2;
  const TrackLayout layout{.radius = radius,
                           .kernel_radius = needle.space.kernel_radius,
                           .segment = needle.space.segment,
                           .below_skin = has_plane_skin(mesh, needle, path)};
  std::vector<RegionModuli> moduli(mesh.data().region_names.size());
  for (const auto& [region, material] : scene.tissue.regions) {
    const double nu = material.poisson_ratio;
    moduli[static_cast<std::size_t>(mesh.region_index(region))] = {
        material.youngs_modulus / (2 * (1 + nu)), nu};
  }
  // The tip never cuts deeper than the needle goes, but for what tissue swings.
  const double depth = path.deepest + needle.cutting.tip_length;
  tissue.membrane_surface = membrane_surface(scene, mesh);
  try {
    return std::make_unique<EmbeddedPath>(
        mesh, EmbeddedTrack(mesh, path.skin_point, path.direction, depth, layout, moduli),
        needle.cutting.tip_length, radius, searches(needle.cutting), std::move(tissue));
  } catch (const InputError& error) {
    refuse_needle(scene, needle, "kernel_radius",
                  std::string("cannot have a track: ") + error.what());
  }
}

}  // namespace stylet
