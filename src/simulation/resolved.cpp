// Where a run writes, and its scene as it runs again from anywhere.
#include "stylet/scene/writer.hpp"
#include "stylet/simulation/model.hpp"
#include "stylet/simulation/run.hpp"

#include <filesystem>
#include <utility>
#include <variant>

namespace stylet {

std::string output_folder(const Scene& scene, const RunOptions& options) {
  if (!options.output.empty()) return options.output;
  if (!scene.output.directory.empty()) return scene.output.directory;
  return "out/" + std::filesystem::path(scene.file).stem().string();
}

Scene with_absolute_paths(Scene scene) {
  const auto make_absolute = [&](std::string& name) {
    name = std::filesystem::absolute(path_in(scene, name)).lexically_normal().string();
  };
  if (auto* file = std::get_if<std::string>(&scene.mesh.source)) make_absolute(*file);
  if (scene.procedure) make_absolute(scene.procedure->file);
  if (scene.image && !scene.image->file.empty()) make_absolute(scene.image->file);
  if (scene.start) make_absolute(scene.start->from);
  return scene;
}

std::string resolved_text(Scene scene) {
  return to_yaml(with_absolute_paths(std::move(scene)));
}

}  // namespace stylet
