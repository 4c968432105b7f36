#include "stylet/scene/quantities.hpp"

#include "stylet/base/text.hpp"

#include <algorithm>
#include <charconv>

namespace stylet {

namespace {

/// Paths that every summary has, or every summary of scenes with needles.
const std::vector<SummaryQuantity>& of_all() {
  static const std::vector<SummaryQuantity> quantities = {{"time", "s"},
                                                          {"worst_quality", ""},
                                                          {"steps", ""},
                                                          {"sub_steps", ""},
                                                          {"solves", ""},
                                                          {"ksp_iterations", ""},
                                                          {"largest_strain.value", ""},
                                                          {"largest_strain.time", "s"},
                                                          {"largest_strain.place.0", "m"},
                                                          {"largest_strain.place.1", "m"},
                                                          {"largest_strain.place.2", "m"},
                                                          {"widespread_strain.value", ""},
                                                          {"widespread_strain.time", "s"},
                                                          {"widespread_strain.place.0", "m"},
                                                          {"widespread_strain.place.1", "m"},
                                                          {"widespread_strain.place.2", "m"},
                                                          {"energy.kinetic", "J"},
                                                          {"energy.strain", "J"},
                                                          {"energy.dissipated", "J"},
                                                          {"energy.external", "J"},
                                                          {"energy.edits", "J"},
                                                          {"energy.balance_error", "J"},
                                                          {"n_nodes", ""},
                                                          {"n_triangles", ""},
                                                          {"n_tetrahedra", ""},
                                                          {"n_ranks", ""}};
  return quantities;
}

const std::vector<SummaryQuantity>& of_needles() {
  static const std::vector<SummaryQuantity> quantities = {
      {"peak_needle_force", "N"}, {"hand_overs", ""}, {"edge_flips", ""},
      {"fallbacks", ""},          {"punctures", ""},  {"pattern_rebuilds", ""},
      {"deformed_inversions", ""}};
  return quantities;
}

const std::vector<SummaryQuantity>& of_a_seed() {
  static const std::vector<SummaryQuantity> quantities = {
      {"implanted_at", "s"}, {"reference.0", "m"},      {"reference.1", "m"}, {"world.0", "m"},
      {"world.1", "m"},      {"tip_displacement", "m"}, {"turned_over", ""}};
  return quantities;
}

/// Beside them, of scenes in space.
const std::vector<SummaryQuantity>& of_a_seed_in_space() {
  static const std::vector<SummaryQuantity> quantities = {{"reference.2", "m"}, {"world.2", "m"}};
  return quantities;
}

const std::vector<SummaryQuantity>& of_a_target() {
  static const std::vector<SummaryQuantity> quantities = {
      {"target_point.0", "m"}, {"target_point.1", "m"}, {"placement_error", "m"}};
  return quantities;
}

const SummaryQuantity stable_step{"stable_step", "s"};

std::optional<std::string> unit_in(const std::vector<SummaryQuantity>& quantities,
                                   const std::string& path) {
  const auto found = std::ranges::find(quantities, path, &SummaryQuantity::path);
  return found == quantities.end() ? std::nullopt : std::optional(found->unit);
}

/// The path behind 'seeds.N.', empty if it is not of a seed.
std::string of_seed(const std::string& path) {
  const std::string list = "seeds.";
  if (!path.starts_with(list)) return {};
  std::size_t number = 0;
  const char* last = path.data() + path.size();
  const auto [end, error] = std::from_chars(path.data() + list.size(), last, number);
  if (error != std::errc() || end == last || *end != '.') return {};
  return std::string(end + 1, last);
}

}  // namespace

std::vector<SummaryQuantity> summary_quantities(const Scene& scene) {
  std::vector<SummaryQuantity> quantities = of_all();
  const bool in_space = scene.dim() == 3;
  std::erase_if(quantities, [&](const SummaryQuantity& quantity) {
    return in_space ? quantity.path == "n_triangles"
                    : quantity.path == "n_tetrahedra" || quantity.path.ends_with(".2");
  });
  if (scene.time.method == TimeMethod::explicit_newmark) quantities.push_back(stable_step);
  const auto add = [&](const std::string& owner, const std::vector<SummaryQuantity>& own) {
    for (const auto& quantity : own) {
      quantities.push_back({owner + quantity.path, quantity.unit});
    }
  };
  if (!scene.needles.empty() || scene.procedure) add("", of_needles());
  std::size_t n_seeds = 0;
  if (scene.procedure) {
    for (const ProcedureRow& row : scene.procedure->rows) {
      if (row.kind != ProcedureRow::Kind::implant) continue;
      const std::string seed = "seeds." + std::to_string(n_seeds++) + ".";
      add(seed, of_a_seed());
      if (!row.target.empty()) add(seed, of_a_target());
    }
  }
  for (const NeedleParameters& needle : scene.needles) {
    for (const Action& action : needle.motion) {
      if (action.kind != ActionKind::implant) continue;
      const std::string seed = "seeds." + std::to_string(n_seeds++) + ".";
      add(seed, of_a_seed());
      if (in_space) add(seed, of_a_seed_in_space());
      if (!action.target.empty()) add(seed, of_a_target());
      if (in_space && !action.target.empty()) add(seed, {{"target_point.2", "m"}});
    }
  }
  for (const Probe& probe : scene.probes) {
    add(below("probes", probe.name) + ".", {{"0", "m"}, {"1", "m"}});
    if (in_space) add(below("probes", probe.name) + ".", {{"2", "m"}});
  }
  for (const PrescribedCurve& prescribed : scene.prescribed) {
    add(below("reactions", prescribed.curve) + ".", {{"0", "N"}, {"1", "N"}});
    if (in_space) add(below("reactions", prescribed.curve) + ".", {{"2", "N"}});
  }
  return quantities;
}

std::optional<std::string> unit_of_quantity(const std::string& path) {
  if (path.starts_with("probes.")) return "m";
  if (path.starts_with("reactions.")) return "N";
  if (path == stable_step.path) return stable_step.unit;
  if (const auto unit = unit_in(of_all(), path)) return unit;
  if (const auto unit = unit_in(of_needles(), path)) return unit;
  const std::string seed = of_seed(path);
  if (const auto unit = unit_in(of_a_seed(), seed)) return unit;
  if (const auto unit = unit_in(of_a_seed_in_space(), seed)) return unit;
  if (seed == "target_point.2") return "m";
  return unit_in(of_a_target(), seed);
}

}  // namespace stylet
