// The rules that tie several keys of a scene together. What needs the mesh (is a target inside the
// tissue, does a curve exist) is checked where the mesh is.
#pragma once

#include "stylet/scene/document.hpp"
#include "stylet/scene/scene.hpp"

namespace stylet {

/// Everything a scene made in code has to keep: the range of every key and the rules. Throws
/// InputError. load_scene has already done it.
void check(const Scene& scene);

/// The rules alone, with messages that point into the document the scene was read from.
void check_rules(const Scene& scene, const Node& document);

}  // namespace stylet
