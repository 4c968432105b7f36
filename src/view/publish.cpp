#include "stylet/view/publish.hpp"

#include "stylet/petsc/gather.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/cell_stress.hpp"
#include "stylet/simulation/notes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace stylet {

namespace {

double colour_of(const Simulation& simulation,
                 Colouring colouring,
                 int cell,
                 std::span<const double> u,
                 PatchPressures& known) {
  if (colouring == Colouring::von_mises) {
    return stress_in(simulation, cell, u, known).stress.von_mises();
  }
  double sum = 0;
  for (const int node : simulation.mesh().cell(cell)) {
    const auto at = 2 * static_cast<std::size_t>(node);
    sum += std::hypot(u[at], u[at + 1]);
  }
  return sum / 3;
}

void publish_tissue(const LiveRun& run, Colouring colouring, Frame& frame) {
  const Simulation& simulation = run.simulation();
  const Mesh& mesh = simulation.mesh();
  const Rotation turn = simulation.rotation();
  const auto u = gather_all(simulation.state().u.get());
  frame.reference.resize(u.size());
  frame.displacement.resize(u.size());
  frame.largest_displacement = 0;
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const auto at = 2 * static_cast<std::size_t>(node);
    const auto x = turn.to_scene(mesh.point(node));
    const Vector2 moved = turn.to_scene(Vector2{u[at], u[at + 1]});
    frame.reference[at] = static_cast<float>(x.x);
    frame.reference[at + 1] = static_cast<float>(x.y);
    frame.displacement[at] = static_cast<float>(moved.x);
    frame.displacement[at + 1] = static_cast<float>(moved.y);
    frame.largest_displacement = std::max(frame.largest_displacement, norm(moved));
  }
  const auto n_cells = static_cast<std::size_t>(mesh.n_cells());
  frame.triangles.resize(3 * n_cells);
  frame.colouring = colouring;
  frame.colour.resize(colouring == Colouring::none ? 0 : n_cells);
  PatchPressures known;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto i = static_cast<std::size_t>(c);
    for (std::size_t k = 0; k < 3; ++k) {
      const int node = mesh.cell(c)[k];
      frame.triangles[3 * i + k] = static_cast<std::uint32_t>(node);
    }
    if (colouring != Colouring::none) {
      frame.colour[i] = static_cast<float>(colour_of(simulation, colouring, c, u, known));
    }
  }
  frame.mesh_version = mesh.version();
  frame.membrane.clear();
  for (const WorldPlace& vertex : simulation.body().world(simulation.membrane())) {
    frame.membrane.push_back(turn.to_scene(vertex.in_plane()));
  }
}

void publish_needle(const LiveRun& run, Frame& frame) {
  const Simulation& simulation = run.simulation();
  const Rotation turn = simulation.rotation();
  const Axis axis{run.height()};
  ShownNeedle& shown = frame.needle;
  shown = {};
  shown.tip = turn.to_scene(axis.at<WorldFrame>(run.tip()));
  shown.skin = turn.to_scene(axis.at<WorldFrame>(run.skin()));
  shown.in_tissue = run.in_tissue();
  shown.phase = "outside";
  if (!shown.in_tissue) return;
  const Needle& needle = *simulation.needle();
  shown.skin = turn.to_scene(axis.at<WorldFrame>(needle.skin()));
  shown.touches = needle.tip_contact() != TipContact::open;
  shown.at_membrane = needle.at_membrane();
  shown.phase = name_of(needle.phase());
  for (const auto& point : needle.track().nodes()) {
    if (!point.attached) continue;
    const auto at = 2 * static_cast<std::size_t>(point.node);
    shown.shaft.push_back({{frame.reference[at] + frame.displacement[at],
                            frame.reference[at + 1] + frame.displacement[at + 1]},
                           point.contact == Contact::stick});
  }
}

void publish_seeds(const LiveRun& run, Frame& frame) {
  const Simulation& simulation = run.simulation();
  const Rotation turn = simulation.rotation();
  std::vector<EmbeddedPoint> places;
  for (const auto& seed : simulation.seeds()) places.push_back(simulation.place_of(seed));
  const auto world = simulation.body().world(places);
  const auto& targets = simulation.scene().targets;
  const bool comes_to_rest = why_not_at_rest(simulation.scene()).empty();
  frame.seeds.clear();
  frame.targets.clear();
  for (const auto& target : targets) {
    frame.targets.push_back(
        {target.name, turn.to_scene(WorldPoint{target.point.x, target.point.y}), false});
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Seed& seed = simulation.seeds()[i];
    ShownSeed shown{turn.to_scene(world[i].in_plane()), seed.needle, seed.target};
    shown.turned_over = seed.turned_over;
    const auto target = std::ranges::find(targets, seed.target, &Target::name);
    if (target != targets.end()) {
      shown.error_now = norm(Vector2{world[i].x - target->point.x, world[i].y - target->point.y});
      // Linear tissue that nothing acts on goes back to where it was (src/MODEL.md, section 9).
      if (comes_to_rest) shown.error_at_rest = distance(places[i].x, *target);
      if (seed.turned_over == 0) shown.band = run.band(seed.target);
      frame.targets[static_cast<std::size_t>(target - targets.begin())].has_seed = true;
    }
    frame.seeds.push_back(std::move(shown));
  }
}

}  // namespace

std::vector<ShownParameter> parameters_of(const LiveRun& run) {
  // A slider reaches from a fifth of the value to five times as much, within what is allowed.
  constexpr double reach = 5;
  constexpr double any = 100;  // where there is nothing now
  std::vector<ShownParameter> shown;
  for (const auto& number : run.parameters()) {
    ShownParameter parameter{number.key, number.doc, number.unit, number.value};
    parameter.low = std::max(number.minimum, number.value / reach);
    parameter.high = std::min(number.maximum, number.value > 0 ? number.value * reach : any);
    parameter.new_operator = number.new_operator;
    shown.push_back(std::move(parameter));
  }
  return shown;
}

std::string method_words(const LiveRun& run) {
  return "method: " + run.method() + " (" + run.method_reason() + ")\n";
}

std::string last_words(LiveRun& run) {
  const Score score = run.finish();
  std::string words = run.simulation().seeds().empty() ? std::string() : text_of(score);
  for (const std::string& note : notes_of(run.simulation())) words += "note: " + note + '\n';
  if (!run.folder().empty()) {
    words += "recorded in " + run.folder() + "; the same again: stylet run " + run.folder() +
             "/scene.yaml --output " + run.folder() + "/run, or stylet view with the scene\n";
  }
  return words;
}

void publish(const LiveRun& run, Colouring colouring, Frame& frame) {
  const Simulation& simulation = run.simulation();
  frame.time = simulation.time();
  frame.method = run.method();
  frame.method_reason = run.method_reason();
  publish_tissue(run, colouring, frame);
  publish_needle(run, frame);
  publish_seeds(run, frame);
  const NeedleStepReport& step = run.last_step().needle;
  frame.tip_force = step.forces.tip;
  frame.shaft_force = step.forces.friction;
  frame.n_stick = step.n_stick;
  frame.n_slip = step.n_slip;
  frame.peak_force = simulation.counts().peak_needle_force;
  frame.punctures = simulation.counts().needle.punctures;
  frame.worst_quality = simulation.counts().worst_quality;
  frame.inverted = simulation.turned_over_now().triangles;
  frame.most_inverted = simulation.turned_over().triangles;
  frame.way = run.speed_limit() * run.step_length();
  frame.longest_way = run.longest_way();
  frame.notes = notes_of(simulation);
  frame.parameters = parameters_of(run);
  frame.history = run.trace().samples();
  frame.can_undo = run.can_undo();
  frame.epoch = run.epoch();
  frame.speed_limit = run.speed_limit();
  frame.replays = run.replays();
  frame.notice = run.notice();
  frame.needle_angle = simulation.scene().needle_angle;
  frame.height = run.height();
  frame.tip = run.tip();
}

}  // namespace stylet
