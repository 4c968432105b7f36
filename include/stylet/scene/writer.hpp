// The resolved scene as YAML in SI units.
#pragma once

#include "stylet/scene/document.hpp"
#include "stylet/scene/scene.hpp"

#include <string>

namespace stylet {

/// Every key that has a value, with the paths that messages need.
[[nodiscard]] Node to_document(const Scene& scene);

/// Loads again to exactly the same scene. The path of a mesh file stays relative to the folder of
/// the scene that named it.
[[nodiscard]] std::string to_yaml(const Scene& scene);

}  // namespace stylet
