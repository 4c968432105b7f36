#include "checks.hpp"

#include "stylet/simulation/track_binding.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace stylet::robustness {

namespace {

double total_area(const Mesh& mesh) {
  double area = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) area += mesh.cell_measure(c);
  return area;
}

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace

Watch::Watch(const Simulation& simulation) : area_(total_area(simulation.mesh())) {
  for (const auto& support : simulation.scene().supports) {
    for (const int node : simulation.mesh().nodes_of(support.curve)) held_.insert(node);
  }
}

std::vector<std::string> Watch::look(const Simulation& simulation, const StepRecord& step) {
  breaches_.clear();
  look_at_mesh(simulation);
  if (simulation.needle() != nullptr && step.sub_steps > 0) look_at_needle(simulation, step);
  return breaches_;
}

void Watch::look_at_mesh(const Simulation& simulation) {
  const Mesh& mesh = simulation.mesh();
  // The floor that src/MODEL.md, section 4, states.
  constexpr double floor = 0.02;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (!(mesh.cell_measure(c) > 0)) breach("inverted element " + std::to_string(c));
    if (mesh.cell_quality(c) < floor) {
      breach("quality " + number(mesh.cell_quality(c)) + " of element " + std::to_string(c));
    }
  }
  // The sum of 20,000 areas carries round-off of about 1e-12.
  const double area = total_area(mesh);
  if (std::abs(area / area_ - 1) > 1e-10) breach("area of the tissue " + number(area));
  for (const auto& seed : simulation.seeds()) {
    const EmbeddedPoint& place = simulation.place_of(seed);
    const auto found = locate(mesh, place.x, place.cell);
    // Barycentric coordinates of a point on an edge are zero up to round-off (embedded_point.cpp).
    const double lowest = *std::ranges::min_element(place.weights);
    if (!found || lowest < -1e-8) breach("a seed lies outside its element");
  }
}

void Watch::look_at_needle(const Simulation& simulation, const StepRecord& step) {
  const Needle& needle = *simulation.needle();
  if (needle.phase() == NeedlePhase::outside || needle.phase() == NeedlePhase::withdrawn) {
    attached_.clear();
    return;
  }
  const Mesh& mesh = simulation.mesh();
  std::vector<int> dofs;
  std::set<int> distinct;
  for (const auto& shaft : needle.track().nodes()) {
    dofs.push_back(2 * shaft.node);
    dofs.push_back(2 * shaft.node + 1);
    if (!distinct.insert(shaft.node).second) breach("a node twice on the path");
  }
  const Vec vectors[1] = {simulation.state().u.get()};
  const auto u = gather(vectors, dofs)[0];
  std::set<int> attached;
  const auto nodes = needle.track().nodes();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i].attached || held_.contains(nodes[i].node)) continue;
    attached.insert(nodes[i].node);
    if (!attached_.contains(nodes[i].node)) continue;
    const double off =
        Axis::across(mesh.point(nodes[i].node)) + u[2 * i + 1] - needle.parameters().height;
    // Prescribed dofs take their values without a solver; 1e-12 m is round-off of 0.1 m.
    if (std::abs(off) > 1e-12) breach("shaft node " + number(off) + " m off the axis");
  }
  attached_ = std::move(attached);
  const bool is_explicit = simulation.scene().time.method == TimeMethod::explicit_newmark;
  const auto set = bind(needle.conditions(), needle.track_operator(), simulation.tissue().n_dofs());
  if (set.mean && !is_explicit) {
    std::vector<int> loaded;
    for (const auto& [dof, weight] : set.mean->weights) loaded.push_back(dof);
    const auto moved = gather(vectors, loaded)[0];
    double mean = 0;
    for (std::size_t i = 0; i < moved.size(); ++i) mean += set.mean->weights[i].value * moved[i];
    // rtol of the solver is 1e-11 of displacements of some centimetres.
    if (std::abs(mean - set.mean->value) > 1e-9) {
      breach("tip " + number(mean - set.mean->value) + " m from its place");
    }
  }
  // Coulomb: the forces never exceed their thresholds (the explicit method decides one step late).
  const auto& parameters = needle.parameters();
  double most_tip = parameters.cutting.cutting_force / parameters.cutting.sharpness;
  if (simulation.scene().membrane) {
    most_tip = std::max(most_tip, simulation.scene().membrane->puncture_force);
  }
  const double slack = 1e-6;
  const bool bounded = parameters.cutting.law == CuttingLaw::consistent && !is_explicit;
  if (bounded) {
    if (step.needle.forces.tip > most_tip * (1 + slack)) {
      breach("tip force " + number(step.needle.forces.tip) + " N");
    }
    if (step.needle.forces.tip < -slack * most_tip) {
      breach("the tip pulls with " + number(step.needle.forces.tip) + " N");
    }
    if (parameters.friction) {
      const double path = needle.track().distances(mesh).front();
      const double most = parameters.friction->static_force * path;
      if (std::abs(step.needle.forces.friction) > most * (1 + slack) + 1e-9) {
        breach("friction " + number(step.needle.forces.friction) + " N");
      }
    }
  }
}

}  // namespace stylet::robustness
