#include "stylet/simulation/model.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/base/text.hpp"
#include "stylet/geometry/rotation.hpp"
#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/box.hpp"
#include "stylet/mesh/embedded_point.hpp"
#include "stylet/mesh/gmsh_reader.hpp"
#include "stylet/mesh/quadratic.hpp"
#include "stylet/mesh/rectangle.hpp"
#include "stylet/mesh/refine.hpp"
#include "stylet/mesh/validate.hpp"
#include "stylet/needle/advance.hpp"
#include "stylet/needle/stops.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/needle_path.hpp"
#include "stylet/simulation/room.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace stylet {

namespace {

MeshData source_mesh(MPI_Comm comm, const Scene& scene, std::string& file_fingerprint) {
  if (const auto* rectangle = std::get_if<RectangleMesh>(&scene.mesh.source)) {
    require_room(comm, scene, 2.0 * rectangle->columns * rectangle->rows);
    return make_rectangle(*rectangle);
  }
  if (const auto* box = std::get_if<BoxMesh>(&scene.mesh.source)) {
    require_room(comm, scene, 6.0 * box->columns * box->rows * box->layers);
    return make_box(*box);
  }
  const std::string name = mesh_path(scene);
  const std::string bytes = read_on_all(comm, name);
  file_fingerprint = fingerprint(bytes);
  MeshData data = read_gmsh(name, bytes, scene.mesh.scale, scene.dim());
  if (data.dim != scene.dim()) {
    refuse_key(scene, "tissue.plane",
               "missing; allowed: stress, strain, because " + name + " is a mesh of triangles");
  }
  require_room(comm, scene, data.n_cells());
  return data;
}

void check_inside(const Scene& scene,
                  const Mesh& mesh,
                  const std::string& key,
                  const std::string& name,
                  ReferencePlace x) {
  if (locate(mesh, x)) return;
  double low[3] = {1e300, 1e300, 1e300};
  double high[3] = {-1e300, -1e300, -1e300};
  const Rotation rotation(scene.needle_angle);  // the user's frame, not the needle's
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const auto p = rotation.to_scene(mesh.place(node));
    const double of_node[3] = {p.x, p.y, p.z};
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], of_node[k]);
      high[k] = std::max(high[k], of_node[k]);
    }
  }
  const double size = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  const bool in_space = mesh.dim() == 3;
  const auto at = [size, in_space](ReferencePlace p) {
    const auto text = [size](double v) { return ten_digits(cleared(v, size)); };
    return "(" + text(p.x) + ", " + text(p.y) + (in_space ? ", " + text(p.z) : "") + ") m";
  };
  throw InputError(scene.file + ": key '" + below(key, name) + "': " + at(rotation.to_scene(x)) +
                   " lies outside the tissue, which spans " + at({low[0], low[1], low[2]}) +
                   " to " + at({high[0], high[1], high[2]}));
}

void turn(MeshData& data, const Rotation& rotation) {
  if (rotation.is_identity()) return;
  for (std::size_t i = 0; i < data.coordinates.size(); i += 2) {
    const Vector2 x = rotation.to_needle(Vector2{data.coordinates[i], data.coordinates[i + 1]});
    data.coordinates[i] = x.x;
    data.coordinates[i + 1] = x.y;
  }
}

// With the key of the scene in front of the mesh's own message.
template <class Lookup>
void check_name(const Scene& scene, const std::string& key, Lookup&& lookup) {
  try {
    lookup();
  } catch (const InputError& error) {
    throw InputError(scene.file + ": key '" + key + "': " + error.what());
  }
}

}  // namespace

std::string path_in(const Scene& scene, const std::string& name) {
  const std::filesystem::path file = name;
  const auto path =
      file.is_absolute() ? file : std::filesystem::path(scene.file).parent_path() / file;
  return path.lexically_normal().string();
}

std::string mesh_path(const Scene& scene) {
  const auto* name = std::get_if<std::string>(&scene.mesh.source);
  return name == nullptr ? std::string() : path_in(scene, *name);
}

std::string procedure_path(const Scene& scene) {
  return scene.procedure ? path_in(scene, scene.procedure->file) : std::string();
}

namespace {

void check_targets(const Scene& scene) {
  const auto& rows = scene.procedure->rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string& target = rows[i].target;
    if (target.empty() ||
        std::ranges::find(scene.targets, target, &Target::name) != scene.targets.end()) {
      continue;
    }
    std::string names;
    for (const Target& known : scene.targets) names += (names.empty() ? "" : ", ") + known.name;
    refuse_key(scene, "procedure.file",
               procedure_path(scene) + " leaves a seed for target '" + target + "'; allowed: " +
                   (names.empty() ? "none, because the scene has no targets" : names));
  }
}

}  // namespace

std::vector<Pushing> pushings_of(const Scene& scene) {
  std::vector<Pushing> pushings;
  if (!scene.procedure) return pushings;
  for (const ProcedureRow& row : scene.procedure->rows) {
    if (row.kind == ProcedureRow::Kind::enter) pushings.push_back({row.needle.name});
    if (row.kind != ProcedureRow::Kind::move || !(row.speed > 0) || pushings.empty()) continue;
    pushings.back().duration += row.duration;
    pushings.back().shortest = std::min(pushings.back().shortest, row.duration);
  }
  return pushings;
}

Scene with_procedure(MPI_Comm comm, Scene scene, std::string& note) {
  if (!scene.procedure || !scene.procedure->rows.empty()) return scene;
  const std::string path = procedure_path(scene);
  scene.procedure->rows = read_procedure(path, read_on_all(comm, path), note);
  if (scene.procedure->rows.empty()) {
    refuse_key(scene, "procedure.file", path + " has no rows; allowed: a recorded procedure");
  }
  check_targets(scene);
  return scene;
}

Scene in_needle_frame(Scene scene) {
  const Rotation rotation(scene.needle_angle);
  if (rotation.is_identity()) return scene;
  const auto turn = [&](Components& c) { c = rotation.to_needle(Vector2{c.x, c.y}); };
  for (auto& target : scene.targets) turn(target.point);
  for (auto& probe : scene.probes) turn(probe.point);
  for (auto& body : scene.body_forces) turn(body.force);
  for (auto& traction : scene.tractions) turn(traction.force);
  for (auto& prescribed : scene.prescribed) {
    auto& x = prescribed.displacement[0];
    auto& y = prescribed.displacement[1];
    const Vector2 turned = rotation.to_needle(Vector2{x.value(), y.value()});
    x = turned.x;
    y = turned.y;
  }
  if (scene.membrane) {
    for (auto& vertex : scene.membrane->polygon) vertex = rotation.to_needle(vertex);
  }
  return scene;
}

NumberedMesh make_mesh(MPI_Comm comm, const Scene& scene) {
  std::string file_fingerprint;
  MeshData data = source_mesh(comm, scene, file_fingerprint);
  validate(data);
  turn(data, Rotation(scene.needle_angle));
  if (scene.mesh.refine > 0) data = refine(data, scene.mesh.refine);
  if (scene.tissue.formulation == Formulation::p2) add_mid_edge_nodes(data);
  auto numbering = number_nodes(data, size_of(comm));
  std::vector<int> old_cell_of_new;
  Mesh mesh(renumber(data, numbering, old_cell_of_new));
  return {std::move(mesh), std::move(numbering.first_node), std::move(numbering.new_of_old),
          std::move(old_cell_of_new), std::move(file_fingerprint)};
}

void check_against_mesh(const Scene& scene, Mesh& mesh) {
  for (const auto& region : scene.tissue.regions) {
    check_name(scene, "tissue.regions", [&] { (void)mesh.region_index(region.region); });
  }
  for (const auto& support : scene.supports) {
    // A point that is held stays where it is: no needle takes it along.
    check_name(scene, "supports", [&] {
      (void)mesh.facets_of(support.curve);
      if (support.kind != SupportKind::free) mesh.lock_curve(support.curve);
    });
  }
  for (const auto& traction : scene.tractions) {
    check_name(scene, "loads.traction", [&] { mesh.lock_curve(traction.curve); });
  }
  for (const auto& prescribed : scene.prescribed) {
    check_name(scene, "prescribed", [&] { mesh.lock_curve(prescribed.curve); });
  }
  if (scene.membrane && !scene.membrane->region.empty()) {
    check_name(scene, "membrane.region", [&] { (void)mesh.region_index(scene.membrane->region); });
  }
  for (const auto& target : scene.targets) {
    check_inside(scene, mesh, "targets", target.name, target.point.place());
  }
  for (const auto& probe : scene.probes) {
    check_inside(scene, mesh, "probes", probe.name, probe.point.place());
  }
  if (scene.membrane && !scene.membrane->surface.empty()) {
    check_name(scene, "membrane.surface", [&] { (void)mesh.facets_of(scene.membrane->surface); });
  }
  for (const auto& needle : scene.needles) {
    check_name(scene, "needles", [&] { (void)skin_of(mesh, needle); });
  }
}

void check_step(const Scene& scene, const Mesh& mesh, double step) {
  const auto require_countable = [&](double duration, const std::string& what) {
    constexpr double most = 1e12;  // far beyond any patience, and time still moves in each of them
    if (duration / step <= most) return;
    throw InputError(scene.file + ": key 'time.step': steps of " + ten_digits(step) +
                     " s are too short for " + what + ", which takes " + ten_digits(duration) +
                     " s; allowed: at most 1e12 steps");
  };
  require_countable(scene.time.duration, "time.duration");
  if (scene.procedure) {
    for (const ProcedureRow& row : scene.procedure->rows) {
      require_countable(row.duration, "a row of " + procedure_path(scene));
      // A step that time.step does not know: its h^2 may vanish.
      if (row.kind != ProcedureRow::Kind::move || row.duration >= 1e-9 * step) continue;
      throw InputError(procedure_path(scene) + ": a row of " + ten_digits(row.duration) +
                       " s; allowed: at least 1e-9 of time.step, which is " + ten_digits(step) +
                       " s");
    }
    for (const Pushing& pushing : pushings_of(scene)) {
      const double longest = std::max(pushing.duration / fewest_steps, pushing.shortest);
      if (pushing.duration == 0 || step <= longest * (1 + 1e-9)) continue;
      throw InputError(scene.file + ": key 'time.step': steps of " + ten_digits(step) +
                       " s are too long for needle '" + pushing.needle + "', which is pushed for " +
                       ten_digits(pushing.duration) + " s, " + ten_digits(pushing.shortest) +
                       " s at least at one speed; allowed: at most " + ten_digits(longest) + " s");
    }
  }
  for (const auto& needle : scene.needles) {
    const double skin = skin_of(mesh, needle);
    const auto travels = travels_of(needle.motion, Axis::along_sign);
    double inserting = 0;  // s
    for (std::size_t i = 0; i < travels.size(); ++i) {
      const Action& action = needle.motion[i];
      const double way = std::abs(along_of(travels[i].to, skin) - along_of(travels[i].from, skin));
      const double moving = action.speed > 0 ? way / action.speed : 0;
      require_countable(action.duration.value_or(moving),
                        "an action of needle '" + needle.name + "'");
      if (action.kind == ActionKind::insert) inserting += moving;
    }
    if (inserting == 0) continue;
    const double longest = inserting / fewest_steps;
    if (step <= longest * (1 + 1e-9)) continue;
    throw InputError(scene.file + ": key 'time.step': steps of " + ten_digits(step) +
                     " s are too long for needle '" + needle.name + "', which is inserted in " +
                     ten_digits(inserting) + " s; allowed: at most a quarter of that, " +
                     ten_digits(longest) + " s");
  }
}

std::function<bool(int)> near_needles(const Scene& scene,
                                      const Mesh& mesh,
                                      const std::vector<double>& heights) {
  return [&scene, &mesh, heights](int node) {
    double size = 0;
    for (const int other : mesh.neighbours(node)) {
      size = std::max(size, distance(mesh.point(node), mesh.point(other)));
    }
    // Nodes that the needle may move or whose edges it may flip stand within about two elements;
    // averaged dilatation hands a flip on to their neighbours.
    const double reach = scene.tissue.formulation == Formulation::p1_averaged ? 4 : 3;
    return std::ranges::any_of(heights, [&](double height) {
      return std::abs(Axis::across(mesh.point(node)) - height) < reach * size;
    });
  };
}

std::unique_ptr<TissueOperator> make_tissue(
    MPI_Comm comm, const Scene& scene, const NumberedMesh& numbered, bool live, Stiffness kept) {
  std::vector<double> heights;
  if (!live) {
    for (const NeedleParameters& needle : scene.needles) {
      if (scene.dim() == 2) heights.push_back(needle.height);
    }
  }
  std::function<bool(int)> needs_flips;
  if (live || !heights.empty()) needs_flips = near_needles(scene, numbered.mesh, heights);
  return std::make_unique<TissueOperator>(comm, numbered.mesh, numbered.first_node, scene.tissue,
                                          needs_flips, kept, live);
}

std::vector<ReferencePoint> region_outline(const Mesh& mesh, const std::string& region) {
  const int index = mesh.region_index(region);
  std::map<int, int> next;  // along the outline, the region to the left
  bool simple = true;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (mesh.region(c) != index) continue;
    const auto n = mesh.cell(c);
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = n[i];
      const int b = n[(i + 1) % 3];
      const auto other = mesh.across(c, a, b);
      if (other && mesh.region(*other) == index) continue;
      simple = next.emplace(a, b).second && simple;  // false where the region touches itself
    }
  }
  // Curves that turn left go around the region, those that turn right around a hole in it.
  std::vector<std::vector<ReferencePoint>> around;
  while (simple && !next.empty()) {
    // Starts at the leftmost node, whatever the numbering.
    const auto first = std::ranges::min_element(next, {}, [&](const auto& edge) {
      const auto x = mesh.point(edge.first);
      return std::pair(x.x, x.y);
    });
    std::vector<ReferencePoint> curve;
    double area = 0;
    for (auto edge = next.find(first->first); edge != next.end();) {
      curve.push_back(mesh.point(edge->first));
      const ReferencePoint to = mesh.point(edge->second);
      area += cross(curve.back() - curve.front(), to - curve.front());
      const int node = edge->second;
      next.erase(edge);
      edge = next.find(node);
    }
    if (area > 0) around.push_back(std::move(curve));
  }
  if (around.size() != 1) {
    throw InputError(mesh.data().source + ": the outline of region '" + region +
                     "' is not one closed curve, so it cannot be a membrane; give a polygon");
  }
  return around.front();
}

}  // namespace stylet
