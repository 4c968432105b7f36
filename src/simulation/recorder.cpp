#include "stylet/simulation/recorder.hpp"

#include "stylet/output/chunk.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/cell_fields.hpp"
#include "stylet/simulation/notes.hpp"
#include "stylet/simulation/score.hpp"

#include <petscversion.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace stylet {

namespace {

using nlohmann::ordered_json;

// Points as the scene has them.
template <class P>
std::vector<std::array<double, 3>> plain(const Rotation& turn, const std::vector<P>& points) {
  std::vector<std::array<double, 3>> out;
  for (const auto& p : points) {
    const SpacePoint x = turn.to_scene(p);
    out.push_back({x.x, x.y, x.z});
  }
  return out;
}

Vector3 moved(ReferencePlace from, WorldPlace to) {
  return {to.x - from.x, to.y - from.y, to.z - from.z};
}

// As many components as the scene has dimensions.
std::vector<double> components(const Scene& scene, double x, double y, double z) {
  std::vector<double> values{x, y};
  if (scene.dim() == 3) values.push_back(z);
  return values;
}

template <class P>
std::vector<double> components(const Scene& scene, const P& p) {
  return components(scene, p.x, p.y, p.z);
}

// The columns of the history, in order: `add` gets name, unit and what gives the value. Values that take
// communication are shared by the columns that need them.
template <class Add>
void each_column(const Simulation& simulation, const StepRecord& step, Add&& add) {
  const Scene& scene = simulation.scene();
  const Rotation turn = simulation.rotation();
  add("time", "s", [&] { return step.t; });
  if (simulation.pierces()) {
    // Before a live hand has entered a needle there is none.
    const bool is_there = simulation.needle() != nullptr;
    constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
    const auto tip = [&]() -> WorldPlace {
      if (!is_there) return {nowhere, nowhere, nowhere};
      const Needle& needle = *simulation.needle();
      return turn.to_scene(needle.on_axis(needle.tip()));
    };
    const auto reference = [&]() -> ReferencePlace {
      if (!is_there) return {nowhere, nowhere, nowhere};
      return turn.to_scene(simulation.needle()->tip_point());
    };
    const NeedleForces& forces = step.needle.forces;
    add("tip_world_x", "m", [&] { return tip().x; });
    add("tip_world_y", "m", [&] { return tip().y; });
    if (scene.dim() == 3) add("tip_world_z", "m", [&] { return tip().z; });
    add("tip_reference_x", "m", [&] { return reference().x; });
    add("tip_reference_y", "m", [&] { return reference().y; });
    if (scene.dim() == 3) add("tip_reference_z", "m", [&] { return reference().z; });
    add("force_tip", "N", [&] { return forces.tip; });
    add("force_friction", "N", [&] { return forces.friction; });
    add("force_needle", "N", [&] { return forces.total(); });
    if (scene.membrane) {
      add("membrane_held", "",
          [&] { return is_there && simulation.needle()->at_membrane() ? 1 : 0; });
      add("punctures", "", [&] { return simulation.counts().needle.punctures; });
    }
    add("n_stuck", "", [&] { return step.needle.n_stick; });
    add("n_sliding", "", [&] { return step.needle.n_slip; });
    add("worst_quality", "", [&] { return simulation.counts().worst_quality; });
  }
  const Energies& e = simulation.energies();
  add("kinetic_energy", "J", [&] { return e.kinetic; });
  add("strain_energy", "J", [&] { return e.strain; });
  add("dissipated_energy", "J", [&] { return e.dissipated; });
  add("external_energy", "J", [&] { return e.external; });
  add("edit_energy", "J", [&] { return e.edits; });
  add("balance_error", "J", [&] { return e.balance_error(); });
  add("solves", "", [&] { return static_cast<double>(step.passes); });
  add("iterations", "", [&] { return static_cast<double>(step.iterations); });
  const auto probes = simulation.body().world(simulation.probes());
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const Vector3 u = turn.to_scene(moved(scene.probes[i].point.place(), probes[i]));
    add(scene.probes[i].name + "_ux", "m", [&] { return u.x; });
    add(scene.probes[i].name + "_uy", "m", [&] { return u.y; });
    if (scene.dim() == 3) add(scene.probes[i].name + "_uz", "m", [&] { return u.z; });
  }
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i) {
    const Vector3 force = turn.to_scene(simulation.body().curve_reaction(i));
    add(scene.prescribed[i].curve + "_fx", "N", [&] { return force.x; });
    add(scene.prescribed[i].curve + "_fy", "N", [&] { return force.y; });
    if (scene.dim() == 3) add(scene.prescribed[i].curve + "_fz", "N", [&] { return force.z; });
  }
}

std::vector<Column> columns(const Simulation& simulation) {
  std::vector<Column> columns;
  each_column(simulation, {}, [&](std::string name, const char* unit, const auto& /*value*/) {
    columns.push_back({std::move(name), unit});
  });
  return columns;
}

std::vector<double> row(const Simulation& simulation, const StepRecord& step) {
  std::vector<double> row;
  each_column(simulation, step, [&](const auto& /*name*/, const char* /*unit*/, const auto& value) {
    row.push_back(value());
  });
  return row;
}

// 0 free, 1 support, 2 stuck, 3 sliding, 4 tip; by node of the run.
std::vector<int> node_states(const Simulation& simulation) {
  std::vector<int> state(static_cast<std::size_t>(simulation.mesh().n_nodes()), 0);
  for (const auto& support : simulation.scene().supports) {
    if (support.kind == SupportKind::free) continue;
    for (const int node : simulation.mesh().nodes_of(support.curve)) {
      state[static_cast<std::size_t>(node)] = 1;
    }
  }
  const Needle* needle = simulation.needle();
  if (needle != nullptr && simulation.mesh().dim() == 2) {
    for (const auto& shaft : needle->track().nodes()) {
      if (!shaft.attached) continue;
      state[static_cast<std::size_t>(shaft.node)] = shaft.contact == Contact::stick ? 2 : 3;
    }
    if (needle->tip_contact() != TipContact::open) {
      state[static_cast<std::size_t>(needle->track().tip())] = 4;
    }
  }
  return state;
}

}  // namespace

Recorder::Recorder(MPI_Comm comm,
                   const Simulation& simulation,
                   const std::string& folder,
                   const RecorderPlace& from)
    : comm_(comm) {
  const auto& output = simulation.scene().output;
  if (output.history) {
    history_.emplace(comm, folder + "/history.csv", columns(simulation), from.history);
  }
  if (!output.snapshots) return;
  const auto& numbered = simulation.numbered();
  old_of_new_node_.resize(numbered.new_of_old_node.size());
  for (std::size_t i = 0; i < old_of_new_node_.size(); ++i) {
    old_of_new_node_[static_cast<std::size_t>(numbered.new_of_old_node[i])] = static_cast<int>(i);
  }
  new_of_old_cell_.resize(numbered.old_cell_of_new.size());
  for (std::size_t i = 0; i < new_of_old_cell_.size(); ++i) {
    new_of_old_cell_[static_cast<std::size_t>(numbered.old_cell_of_new[i])] = static_cast<int>(i);
  }
  if (from.snapshots) {
    snapshots_.emplace(comm, folder, *from.snapshots);
    wait_for_next(from.snapshots->time, simulation.scene());
    return;
  }
  snapshots_.emplace(comm, folder);
  snapshot(simulation);
}

void Recorder::wait_for_next(double time, const Scene& scene) {
  const double interval = *scene.output.snapshots;
  constexpr double round_off = 1e-9;
  next_snapshot_ = (std::floor(time / interval * (1 + round_off)) + 1) * interval;
  last_snapshot_ = time;
}

RecorderPlace Recorder::settle() {
  RecorderPlace place;
  if (history_) place.history = history_->settle();
  if (snapshots_) place.snapshots = snapshots_->settle();
  return place;
}

void Recorder::record(const Simulation& simulation, const StepRecord& step) {
  static const LogEvent event("StyletRecord");
  const LogScope scope(event);
  if (history_) history_->write(row(simulation, step));
  constexpr double round_off = 1e-9;
  if (snapshots_ && step.t >= next_snapshot_ * (1 - round_off)) {
    if (history_) history_->flush();
    snapshot(simulation);
  }
}

void Recorder::finish(const Simulation& simulation) {
  if (history_) history_->flush();  // the quick part first: a run that is stopped may be ended soon
  if (snapshots_ && last_snapshot_ != simulation.time()) snapshot(simulation);
  close();
}

void Recorder::close() {
  if (snapshots_) snapshots_->close();
  if (history_) history_->close();
}

void Recorder::snapshot(const Simulation& simulation) {
  static const LogEvent event("StyletSnapshot");
  const LogScope scope(event);
  const Mesh& mesh = simulation.mesh();
  const Rotation turn = simulation.rotation();
  const auto& numbered = simulation.numbered();
  const double t = simulation.time();
  wait_for_next(t, simulation.scene());

  Snapshot snapshot;
  snapshot.time = t;
  const Needle* needle = simulation.needle();
  snapshot.phase = needle != nullptr ? name_of(needle->phase()) : "";
  snapshot.dim = mesh.dim();
  const auto dim = static_cast<std::size_t>(mesh.dim());
  std::vector<double> coordinates;
  coordinates.reserve(dim * old_of_new_node_.size());
  for (std::size_t i = 0; i < old_of_new_node_.size(); ++i) {
    const auto x = turn.to_scene(mesh.place(numbered.new_of_old_node[i]));
    coordinates.insert(coordinates.end(), {x.x, x.y});
    if (dim == 3) coordinates.push_back(x.z);
  }
  std::vector<int> connectivity;
  connectivity.reserve((dim + 1) * new_of_old_cell_.size());
  for (const int c : new_of_old_cell_) {
    for (const int node : mesh.cell(c)) {
      connectivity.push_back(old_of_new_node_[static_cast<std::size_t>(node)]);
    }
  }
  snapshot.coordinates = coordinates;
  snapshot.connectivity = connectivity;
  snapshot.mesh_version = mesh.version();
  snapshot.connectivity_version = mesh.connectivity_version();

  const auto u = gather_all(simulation.state().u.get());
  const auto v = gather_all(simulation.state().v.get());
  const auto states = node_states(simulation);
  const Range nodes = chunk(mesh.n_nodes(), rank_of(comm_), size_of(comm_));
  Field u_field{"u", false, mesh.dim(), {}, "m"};
  Field v_field{"v", false, mesh.dim(), {}, "m/s"};
  FlagField state_field{"node_state", false, {}};
  for (int i = nodes.begin; i < nodes.end; ++i) {
    const auto at = static_cast<std::size_t>(numbered.new_of_old_node[static_cast<std::size_t>(i)]);
    const auto add = [&](const std::vector<double>& of, Field& field) {
      const Vector2 turned = turn.to_scene(Vector2{of[dim * at], of[dim * at + 1]});
      field.values.insert(field.values.end(), {turned.x, turned.y});
      if (dim == 3) field.values.push_back(of[dim * at + 2]);
    };
    add(u, u_field);
    add(v, v_field);
    state_field.values.push_back(states[at]);
  }
  snapshot.fields.push_back(std::move(u_field));
  snapshot.fields.push_back(std::move(v_field));
  snapshot.flags.push_back(std::move(state_field));
  add_cell_fields(simulation, new_of_old_cell_,
                  chunk(mesh.n_cells(), rank_of(comm_), size_of(comm_)), u, snapshot);

  if (needle != nullptr && needle->phase() != NeedlePhase::withdrawn) {
    constexpr double outside = 0.01;  // m of the needle shown in front of the skin
    snapshot.polylines.push_back({"needle",
                                  plain(turn, std::vector{needle->on_axis(needle->skin() - outside),
                                                          needle->on_axis(needle->tip())}),
                                  false});
  }
  if (!simulation.membrane().empty()) {
    snapshot.polylines.push_back(
        {"membrane", plain(turn, simulation.body().world(simulation.membrane())), true});
  }
  if (!simulation.seeds().empty()) {
    std::vector<EmbeddedPoint> places;
    for (const auto& seed : simulation.seeds()) places.push_back(simulation.place_of(seed));
    snapshot.point_sets.push_back({"seeds", plain(turn, simulation.body().world(places))});
  }
  if (!simulation.scene().targets.empty()) {
    std::vector<ReferencePlace> targets;
    for (const auto& target : simulation.scene().targets) targets.push_back(target.point.place());
    snapshot.point_sets.push_back({"targets", plain(turn, targets)});
  }
  snapshots_->write(snapshot);
}

ordered_json summarise(MPI_Comm comm,
                       const Simulation& simulation,
                       const std::string& status,
                       const std::map<std::string, double>& wall_times) {
  const Scene& scene = simulation.scene();
  const Rotation turn = simulation.rotation();
  const RunCounts& counts = simulation.counts();
  ordered_json summary;
  summary["status"] = status;
  summary["scene"] = scene.file;
  if (scene.start) summary["fingerprints"]["start"] = simulation.start_fingerprint();
  summary["time"] = simulation.time();
  summary["seeds"] = ordered_json::array();
  std::vector<EmbeddedPoint> places;
  for (const auto& seed : simulation.seeds()) places.push_back(simulation.place_of(seed));
  const auto world = simulation.body().world(places);
  const auto errors = simulation.placement_errors();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& seed = simulation.seeds()[i];
    ordered_json entry;
    entry["needle"] = seed.needle;
    entry["implanted_at"] = seed.time;
    entry["reference"] = components(scene, turn.to_scene(places[i].x));
    if (!hides_places(scene)) entry["world"] = components(scene, turn.to_scene(world[i]));
    entry["tip_displacement"] = norm(seed.displacement);
    entry["turned_over"] = seed.turned_over;
    for (const auto& target : scene.targets) {
      if (target.name != seed.target) continue;
      entry["target"] = target.name;
      entry["target_point"] = components(scene, turn.to_scene(target.point.place()));
      // Before the end the seed is not where it will be.
      if (status == "completed" && !hides_places(scene)) entry["placement_error"] = errors[i];
    }
    summary["seeds"].push_back(entry);
  }
  if (simulation.pierces()) {
    summary["peak_needle_force"] = counts.peak_needle_force;
    summary["hand_overs"] = counts.needle.hand_overs;
    summary["edge_flips"] = counts.edge_flips;
    summary["fallbacks"] = counts.needle.fallbacks;
    summary["punctures"] = counts.needle.punctures;
    summary["pattern_rebuilds"] = counts.pattern_rebuilds;
    summary["deformed_inversions"] = simulation.turned_over().triangles;
  }
  const auto add_strain = [&](const char* name, const StrainPeak& peak) {
    const auto place = turn.to_scene(peak.place);
    summary[name] = {
        {"value", peak.value}, {"time", peak.time}, {"place", components(scene, place)}};
  };
  add_strain("largest_strain", simulation.largest_strain().anywhere);
  add_strain("widespread_strain", simulation.largest_strain().widespread);
  summary["worst_quality"] = counts.worst_quality;
  summary["steps"] = counts.steps;
  summary["sub_steps"] = counts.sub_steps;
  summary["solves"] = counts.passes;
  summary["ksp_iterations"] = counts.iterations;
  if (scene.time.method == TimeMethod::explicit_newmark) {
    summary["stable_step"] = counts.stable_step;
  }
  const auto probes = simulation.body().world(simulation.probes());
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const Vector3 u = turn.to_scene(moved(scene.probes[i].point.place(), probes[i]));
    summary["probes"][scene.probes[i].name] = components(scene, u);
  }
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i) {
    const Vector3 force = turn.to_scene(simulation.body().curve_reaction(i));
    summary["reactions"][scene.prescribed[i].curve] = components(scene, force);
  }
  const Energies& e = simulation.energies();
  summary["energy"] = {{"kinetic", e.kinetic},       {"strain", e.strain},
                       {"dissipated", e.dissipated}, {"external", e.external},
                       {"edits", e.edits},           {"balance_error", e.balance_error()}};
  summary["notes"] = notes_of(simulation);
  summary["n_nodes"] = simulation.mesh().n_nodes();
  summary["n_" + scene.cells()] = simulation.mesh().n_cells();
  summary["n_ranks"] = size_of(comm);
  summary["wall_times"] = wall_times;
  if (const auto& mesh = simulation.numbered().file_fingerprint; !mesh.empty()) {
    summary["fingerprints"]["mesh"] = mesh;
  }
  if (scene.procedure) {
    summary["fingerprints"]["procedure"] = fingerprint_of(scene.procedure->rows);
    summary["score"] = json_of(score_of(simulation));
  }
  summary["solver"] = simulation.body().solver();
  summary["solver_options"] = solver_options();
  summary["versions"] = {
      {"stylet", STYLET_VERSION},
      {"petsc", std::to_string(PETSC_VERSION_MAJOR) + "." + std::to_string(PETSC_VERSION_MINOR) +
                    "." + std::to_string(PETSC_VERSION_SUBMINOR)}};
  return summary;
}

}  // namespace stylet
