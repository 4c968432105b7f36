#include "stylet/scene/loader.hpp"

#include "stylet/scene/check.hpp"
#include "stylet/scene/overrides.hpp"
#include "stylet/scene/schema.hpp"

#include <algorithm>

namespace stylet {

namespace {

bool is_given(const Node& document, const std::string& path) {
  return closest(document, path).path == path;
}

/// Defaults that depend on other keys; the schema names each of them in its `otherwise`.
void resolve(Scene& scene, const Node& document) {
  const bool is_explicit = scene.time.method == TimeMethod::explicit_newmark;
  if (is_explicit && !is_given(document, "tissue.mass")) scene.tissue.mass = MassKind::lumped;
  if (!is_given(document, "tissue.plane")) scene.tissue.plane.reset();
  if (scene.tissue.plane != Plane::stress && !is_given(document, "tissue.formulation")) {
    const bool averaged = std::ranges::any_of(
        scene.tissue.regions, [](const RegionTissue& region) { return locks(region.material); });
    if (averaged) scene.tissue.formulation = Formulation::p1_averaged;
  }
  for (std::size_t i = 0; i < scene.needles.size(); ++i) {
    NeedleParameters& needle = scene.needles[i];
    const std::string law = "needles." + std::to_string(i) + ".cutting.law";
    if (is_explicit && !is_given(document, law)) needle.cutting.law = CuttingLaw::lagged;
    if (needle.name.empty()) needle.name = "needle" + std::to_string(i + 1);
    for (Action& action : needle.motion) {
      const bool no_target = action.kind == ActionKind::implant && action.target.empty();
      if (no_target && scene.targets.size() == 1) action.target = scene.targets.front().name;
    }
  }
  const bool quasi_static = scene.time.method == TimeMethod::quasi_static;
  const bool ends_itself = !scene.needles.empty() || scene.procedure;
  if (!ends_itself && quasi_static && !is_given(document, "time.duration")) {
    scene.time.duration = scene.time.step;
  }
}

}  // namespace

Scene load_scene(const std::string& file_name,
                 const std::string& text,
                 const std::vector<std::string>& overrides) {
  Node document = parse_yaml(file_name, text);
  for (const std::string& change : overrides) apply_override(document, file_name, change);
  Scene scene;
  scene.file = file_name;
  scene_codec().read(document, scene);
  resolve(scene, document);
  check_rules(scene, document);
  scene.document = std::move(document);
  return scene;
}

}  // namespace stylet
