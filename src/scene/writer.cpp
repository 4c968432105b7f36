#include "stylet/scene/writer.hpp"

#include "stylet/scene/check.hpp"
#include "stylet/scene/schema.hpp"

namespace stylet {

Node to_document(const Scene& scene) {
  Node document = scene_codec().write(scene);
  document.place({}, scene.file.empty() ? scene_in_code : scene.file);
  return document;
}

std::string to_yaml(const Scene& scene) {
  return yaml_text(to_document(scene));
}

}  // namespace stylet
