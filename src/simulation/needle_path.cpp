#include "stylet/simulation/needle_path.hpp"

#include "stylet/base/text.hpp"
#include "stylet/needle/stops.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/space_way.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace stylet {

namespace {

std::string needle_key(std::size_t needle) {
  return "needles." + std::to_string(needle);
}

const char* name_of(ActionKind kind) {
  switch (kind) {
    case ActionKind::insert:
      return "insert";
    case ActionKind::retract:
      return "retract";
    case ActionKind::implant:
      return "implant";
    case ActionKind::hold:
      return "hold";
    case ActionKind::settle:
      break;
  }
  return "settle";
}

std::string action_key(const Scene& scene, std::size_t needle, std::size_t action) {
  return needle_key(needle) + ".motion." + std::to_string(action) + "." +
         name_of(scene.needles[needle].motion[action].kind);
}

/// Where the axis crosses an edge, as along coordinate. The lower end of an edge belongs to it, the
/// upper one does not: a way through a node crosses as often as it has to.
std::optional<double> crossing(ReferencePoint a, ReferencePoint b, double height) {
  const double ya = Axis::across(a);
  const double yb = Axis::across(b);
  if ((ya > height) == (yb > height)) return std::nullopt;
  const double s = (height - ya) / (yb - ya);
  return Axis::along(a + s * (b - a));
}

/// Where the axis goes from one region to another or to the outside (index -1), in its order.
struct Border {
  double along;
  int before;
  int behind;
};

std::vector<Border> borders(const Mesh& mesh, double height) {
  std::vector<Border> found;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto n = mesh.cell(c);
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = n[i];
      const int b = n[(i + 1) % 3];
      const auto along = crossing(mesh.point(a), mesh.point(b), height);
      if (!along) continue;
      const auto other = mesh.across(c, a, b);
      const int beyond = other ? mesh.region(*other) : -1;
      if (beyond == mesh.region(c) || (other && *other < c)) continue;
      // Of an edge that runs up, seen from inside, the cell lies on the side of -x: ahead.
      const bool enters = Axis::across(mesh.point(b)) > Axis::across(mesh.point(a));
      found.push_back(enters ? Border{*along, beyond, mesh.region(c)}
                             : Border{*along, mesh.region(c), beyond});
    }
  }
  std::ranges::sort(found, {}, &Border::along);
  // Where several meet at one point, each begins where the last one ended.
  int region = -1;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double here = found[i].along + 1e-12 * std::abs(found[i].along);
    for (std::size_t j = i; j < found.size() && found[j].along <= here; ++j) {
      if (found[j].before != region) continue;
      std::swap(found[i], found[j]);
      break;
    }
    region = found[i].behind;
  }
  return found;
}

/// The curve with a condition whose edge the way meets, and where; depth 0 is the entry.
void check_curve(const Scene& scene,
                 const Mesh& mesh,
                 std::size_t needle,
                 const NeedlePath& path,
                 const std::string& curve,
                 const std::string& condition,
                 bool may_be_entered = false) {
  const double height = scene.needles[needle].height;
  const auto& data = mesh.data();
  for (const int f : mesh.facets_of(curve)) {
    const int a = data.facets[2 * static_cast<std::size_t>(f)];
    const int b = data.facets[2 * static_cast<std::size_t>(f) + 1];
    const double ya = Axis::across(mesh.point(a));
    const double yb = Axis::across(mesh.point(b));
    if (std::max(ya, yb) < height || std::min(ya, yb) > height) continue;
    // An edge along the axis is met at its nearer end.
    double along = std::min(Axis::along(mesh.point(a)), Axis::along(mesh.point(b)));
    if (ya != yb)
      along =
          Axis::along(mesh.point(a) + (height - ya) / (yb - ya) * (mesh.point(b) - mesh.point(a)));
    const double depth = along - path.skin;
    const double round_off = 1e-9 * path.end;
    if (depth < -round_off || depth > path.deepest + round_off) continue;
    if (may_be_entered && depth <= round_off) continue;
    const ReferencePoint x = Axis{height}.at<ReferenceFrame>(along);
    refuse_key(scene, needle_key(needle) + ".height",
               "needle '" + scene.needles[needle].name + "' " +
                   (depth <= round_off ? "enters" : "leads") + " through curve '" + curve +
                   "' at " + point_text(scene, x) + ", which is " + condition +
                   "; allowed: a way that meets no such curve");
  }
}

struct HeldCurve {
  std::string curve;
  std::string condition;
};
std::vector<HeldCurve> held_curves(const Scene& scene) {
  std::vector<HeldCurve> curves;
  for (const auto& support : scene.supports) {
    if (support.kind == SupportKind::free) continue;
    curves.push_back({support.curve, "held (supports." + support.curve + ": " +
                                         (support.kind == SupportKind::fixed ? "fixed" : "roller") +
                                         ")"});
  }
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i) {
    curves.push_back({scene.prescribed[i].curve, "moved (prescribed." + std::to_string(i) + ")"});
  }
  return curves;
}

void check_curves(const Scene& scene,
                  const Mesh& mesh,
                  const Conditions& conditions,
                  std::size_t needle,
                  const NeedlePath& path) {
  for (const auto& [curve, condition] : held_curves(scene)) {
    check_curve(scene, mesh, needle, path, curve, condition);
  }
  // The mesh has to keep a loaded curve as it is, so that no needle gets through one.
  for (std::size_t i = 0; i < scene.tractions.size(); ++i) {
    check_curve(scene, mesh, needle, path, scene.tractions[i].curve,
                "loaded (loads.traction." + std::to_string(i) + ")", true);
  }
  // The node that slides to the axis takes its conditions along.
  const auto held = conditions.prescribed(0);
  for (const int dof : {2 * path.entry.node, 2 * path.entry.node + 1}) {
    if (!std::ranges::binary_search(held, dof, {}, &PrescribedDof::dof)) continue;
    refuse_key(scene, needle_key(needle) + ".height",
               "needle '" + scene.needles[needle].name + "' enters at " +
                   point_text(scene, path.entry.x) + ", next to a point that is held, " +
                   point_text(scene, mesh.point(path.entry.node)) +
                   "; allowed: an entry at least an element away from it");
  }
}

void check_way(const Scene& scene, const Mesh& mesh, std::size_t needle, const NeedlePath& path) {
  if (path.deepest < path.end) return;
  const double height = scene.needles[needle].height;
  const auto travels = travels_of(scene.needles[needle].motion, Axis::along_sign);
  std::size_t action = 0;
  while (along_of(travels[action].to, path.skin) - path.skin < path.end) ++action;
  const double leaves = path.skin + path.end;
  std::string text = "ends " + brief(along_of(travels[action].to, path.skin) - path.skin) +
                     " m behind the entry point, and the way of needle '" +
                     scene.needles[needle].name + "' leaves the tissue at " +
                     point_text(scene, Axis{height}.at<ReferenceFrame>(leaves)) + ", " +
                     brief(path.end) + " m behind it";
  for (const Border& border : borders(mesh, height)) {
    if (border.along <= leaves || border.before >= 0) continue;
    text += ", to enter it again at " +
            point_text(scene, Axis{height}.at<ReferenceFrame>(border.along));
    break;
  }
  refuse_key(scene, action_key(scene, needle, action), text + "; allowed: a way inside the tissue");
}

}  // namespace

double skin_of(const Mesh& mesh, const NeedleParameters& needle) {
  return mesh.dim() == 3 ? 0 : Axis::along(find_entry(mesh, {needle.height}, needle.name).x);
}

NeedlePath find_path(const Scene& scene, const Mesh& mesh, std::size_t needle) {
  const NeedleParameters& parameters = scene.needles[needle];
  if (mesh.dim() == 3) return find_way(scene, mesh, parameters);
  NeedlePath path;
  path.entry = find_entry(mesh, {parameters.height}, parameters.name);
  path.skin_point = path.entry.x;
  path.direction = in_space(Axis::direction());
  path.skin = Axis::along(path.entry.x);
  for (const Travel& travel : travels_of(parameters.motion, Axis::along_sign)) {
    path.deepest = std::max(path.deepest, along_of(travel.to, path.skin) - path.skin);
  }
  double entered = path.skin;
  int region = -1;
  for (const Border& border : borders(mesh, parameters.height)) {
    if (region >= 0) {
      path.end = border.along - path.skin;
      const double from = entered - path.skin;
      if (from < path.deepest && border.along > entered) {
        path.pieces.push_back({mesh.data().region_names[static_cast<std::size_t>(region)], from,
                               std::min(path.deepest, path.end)});
      }
    }
    region = border.behind;
    entered = border.along;
    if (region < 0) break;
  }
  return path;
}

std::vector<double> crossings(const NeedlePath& path,
                              double height,
                              std::span<const ReferencePoint> polygon) {
  std::vector<double> depths;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto along = crossing(polygon[i], polygon[(i + 1) % polygon.size()], height);
    if (along && *along >= path.skin && *along - path.skin <= path.deepest) {
      depths.push_back(*along - path.skin);
    }
  }
  std::ranges::sort(depths);
  return depths;
}

bool skin_is_at_rest(const Scene& scene, std::size_t needle) {
  if (needle == 0) return true;
  Scene before = scene;
  before.needles.resize(needle);
  return why_not_at_rest(before).empty();
}

void check_needles(const Scene& scene, const Mesh& mesh, const Conditions& conditions) {
  if (mesh.dim() == 3) {
    check_ways(scene, mesh);
    return;
  }
  for (std::size_t i = 0; i < scene.needles.size(); ++i) {
    const NeedlePath path = find_path(scene, mesh, i);
    const auto fault =
        find_fault(scene.needles[i].motion, Axis::along_sign, path.skin, skin_is_at_rest(scene, i));
    if (fault) {
      refuse_key(scene, action_key(scene, i, fault->action),
                 "needle '" + scene.needles[i].name + "', entry point at " +
                     point_text(scene, path.entry.x) + ": " + fault->reason);
    }
    check_way(scene, mesh, i, path);
    // The cutting force acts in full once all of the tip is in.
    if (scene.needles[i].cutting.tip_length > path.end) {
      refuse_key(scene, needle_key(i) + ".cutting.tip_length",
                 brief(scene.needles[i].cutting.tip_length) +
                     " m is longer than the way of needle '" + scene.needles[i].name +
                     "' through the tissue, " + brief(path.end) +
                     " m; allowed: a tip that can be in with all of its length");
    }
    check_curves(scene, mesh, conditions, i, path);
  }
}

std::string held_points_text(const Scene& scene,
                             const Mesh& mesh,
                             std::span<const PrescribedDof> held,
                             std::span<const int> nodes) {
  const auto is_held = [&](int node) {
    return std::ranges::any_of(std::array{2 * node, 2 * node + 1}, [&](int dof) {
      return std::ranges::binary_search(held, dof, {}, &PrescribedDof::dof);
    });
  };
  std::vector<int> met;
  std::ranges::copy_if(nodes, std::back_inserter(met), is_held);
  if (met.empty()) return {};
  std::vector<std::string> places;
  for (const auto& [curve, condition] : held_curves(scene)) {
    std::vector<std::string> points;
    for (const int node : mesh.nodes_of(curve)) {
      if (std::ranges::find(met, node) == met.end()) continue;
      points.push_back(point_text(scene, mesh.point(node)));
    }
    if (points.empty()) continue;
    std::ranges::sort(points);  // the same on every number of ranks
    places.push_back(join(points) + " of curve '" + curve + "', which is " + condition);
  }
  return join(places, "; ");
}

}  // namespace stylet
