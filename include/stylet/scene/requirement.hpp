// A rule of a scene that is kept or refused, with a message that points into its document.
#pragma once

#include "stylet/scene/document.hpp"
#include "stylet/scene/scene.hpp"

#include <string>

namespace stylet {

/// Throws InputError for the key `path` of the document, or where it should be, unless the rule is kept.
void require(const Node& document, bool kept, const std::string& path, const std::string& allowed);

/// The path of an item of a list.
[[nodiscard]] std::string item(const std::string& list, std::size_t i);

/// What a scene in space has, and what only one in the plane has. Of a file the mesh will tell.
void check_dimension(const Scene& scene, const Node& document);

}  // namespace stylet
